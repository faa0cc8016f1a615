"""The section on what vehicles can do, and the one on a flight through a failure."""

from pathlib import Path

import msgspec
import pytest

from bench.record import FILE_NAME, Capability, Cell, Curve, Judged, Key, LastMetre, Plane, Quiet, RecordError
from bench.report.pictures import draw_all
from bench.report.pictures import vehicles as pictured
from bench.report.sections.capability import capability as section
from bench.report.sections.capability import last_metre
from bench.report.sections.losses import mission
from bench.results.rows import Run, read_run
from tests import made_up
from tests.made_up import cell, header, problem, record

WHOLE = made_up.capability().authority[0]
BOX = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
CAPABILITY = made_up.capability(
    authority=[
        WHOLE,
        msgspec.structs.replace(WHOLE, fault=0, condition=4321.0, volume_share=0.25),
        msgspec.structs.replace(WHOLE, fault=1, rank=2, condition=None, volume_share=0.0),
    ],
    served=[
        made_up.served("pinv", 1000, 2000, within_5pct=1200),
        made_up.served("svd", 1000, 2000, within_5pct=1200),
        made_up.served("scaled", 2000, 2000),
    ],
    curves=[
        Curve(method="pinv", size=[0.5, 1.0, 2.0], error_p50=[0.0, 0.2, 0.6], error_max=[0.0, 0.3, 0.7]),
        Curve(method="svd", size=[0.5, 1.0, 2.0], error_p50=[0.0, 0.2, 0.6], error_max=[0.0, 0.3, 0.7]),
        Curve(method="scaled", size=[0.5, 1.0, 2.0], error_p50=[0.0, 0.0, 0.5], error_max=[0.0, 0.0, 0.5]),
    ],
    planes=[
        Plane(
            x="surge",
            y="sway",
            held="yaw",
            held_at=0.0,
            attainable=BOX,
            closed_form=BOX,
            demands=[(0.5, 0.5, "active")],
        )
    ],
)


def run_with(tmp_path: Path, *capabilities: Capability) -> Run:
    return made_up.run(tmp_path, *capabilities, cell())


def test_the_section_shows_authority_and_the_shares_served(tmp_path: Path) -> None:
    text = section(run_with(tmp_path, CAPABILITY), frozenset())
    assert "62.5 %" in text
    assert "55.5 %" in text
    assert "-3.00 … 3.00" in text
    assert "50.0 % (47.8 … 52.2)" in text  # Clopper and Pearson's for 1000 of 2000


def test_failures_that_lose_rank_or_leave_a_nearly_singular_vehicle_are_pointed_out(tmp_path: Path) -> None:
    text = section(run_with(tmp_path, CAPABILITY), frozenset())
    assert "**Lost rank**: without thruster 1" in text
    assert "**Nearly singular** with thruster 0 off" in text
    # Red before: "closed form 100 %" and "served 100 %" of a line, as if of all that the vehicle could do.
    assert "*Closed form*, *safe* and *served* without thruster 1 are shares of a plane" in text


def test_a_thruster_goes_by_its_name_where_it_has_one(tmp_path: Path) -> None:
    named = msgspec.structs.replace(CAPABILITY, names=["bow", "stern"])
    text = section(run_with(tmp_path, named), frozenset())
    assert "**Lost rank**: without thruster stern" in text
    assert "**Nearly singular** with thruster bow off" in text


def test_methods_that_serve_the_same_share_a_line_and_the_best_comes_first(tmp_path: Path) -> None:
    lines = section(run_with(tmp_path, CAPABILITY), frozenset()).splitlines()
    served = [line.split("|")[1].strip() for line in lines if line.startswith("|")]
    assert "pinv, svd" in served
    order = [line for line in lines if "scaled" in line or "pinv, svd" in line]
    assert "scaled" in order[0]


def test_a_record_without_capabilities_has_no_such_section_and_no_such_pictures(tmp_path: Path) -> None:
    run = run_with(tmp_path)
    assert section(run, frozenset()) == ""
    assert pictured.reach(run, "ukwial") is None
    assert pictured.error(run, "ukwial") is None


def test_pictures_are_drawn_and_curves_that_coincide_share_a_line(tmp_path: Path) -> None:
    run = run_with(tmp_path, CAPABILITY)
    drawn = pictured.reach(run, "ukwial")
    assert drawn is not None
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == [
        "attainable",
        "closed form inside the limits",
        "mission, active",
    ]
    drawn = pictured.error(run, "ukwial")
    assert drawn is not None
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == ["scaled", "pinv, svd"]


def test_a_curve_with_fewer_errors_than_sizes_is_a_damaged_line(tmp_path: Path) -> None:
    curve = {"method": "pinv", "size": [0.5, 1.0], "error_p50": [0.0, 0.1], "error_max": [0.0]}
    line = msgspec.to_builtins(CAPABILITY) | {"curves": [curve]}
    with pytest.raises(msgspec.ValidationError, match="need as many numbers each"):
        msgspec.convert(line, Capability)


def test_the_last_metre_has_a_line_for_each_way_one_for_steps_and_a_picture(tmp_path: Path) -> None:
    sizes = {"share": [0.02, 0.05], "step_p50": [0.0274, 0.0108]}
    ways = [
        LastMetre(way="linear map", error_p50=[1.0, 0.9], error_p95=[1.0, 1.0], missed=0.25, off_m=0.33,
                  turns_hz=2.5, **sizes),
        LastMetre(way="curve", error_p50=[0.028, 0.0107], error_p95=[0.05, 0.0167], missed=None, off_m=None,
                  turns_hz=None, **sizes),
    ]  # fmt: skip
    run = run_with(tmp_path, msgspec.structs.replace(CAPABILITY, last_metre=ways))
    text = last_metre(run, draw_all(run, tmp_path))
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if "|" in line]
    assert rows[0][1:3] == ["2.00 %: missed, 95 %", "5.00 %: missed, 95 %"]
    assert rows[2] == ["linear map", "100 %, 100 %", "90.0 %, 100 %", "25.0 %", "0.330", "2.50"]
    assert rows[3][:3] == ["curve", "2.80 %, 5.00 %", "1.07 %, 1.67 %"]
    assert rows[4][:3] == ["by steps alone", "2.74 %", "1.08 %"]
    assert "](last-metre-ukwial.svg)" in text
    drawn = pictured.last_metre(run, "ukwial")
    assert drawn is not None
    assert [each.get_text() for each in drawn.legends[0].get_texts()] == [
        "linear map",
        "curve",
        "by steps alone",
    ]
    (tmp_path / "nothing").mkdir()
    nothing = run_with(tmp_path / "nothing", CAPABILITY)
    assert last_metre(nothing, frozenset()) == ""
    assert pictured.last_metre(nothing, "ukwial") is None


def test_a_flight_through_a_failure_shows_before_and_after(tmp_path: Path) -> None:
    def flown(vehicle: str, demands: str, lost: float) -> Cell:
        loss: dict[str, float | None] = {"lost_wrench_max": lost, "answered_share": 1.0}
        loss |= {"within_1pct_share": 0.5, "direction_error_max_deg": 3.0}
        judged = Judged(answers=10, counts={"SOLVED": 10}, wrench_error_max=[0.0], agrees=True, loss=loss)
        return cell("clip", key=Key(vehicle, demands, "clip"), judged=judged)

    once = problem("ukwial-f2", whole="ukwial", fault=2)
    twice = msgspec.structs.replace(once, vehicle="ukwial-f2-f0", faults=[(0, 0.0), (2, 0.0)])
    cells = [
        flown("ukwial", "mission", 0.111),
        flown("ukwial-f2", "mission-fault", 0.222),
        flown("ukwial-f2-f0", "mission-fault", 0.333),  # a failure of another vehicle, ukwial-f2
    ]
    text = mission(made_up.run(tmp_path, once, twice, *cells), frozenset())
    assert "### ukwial, then ukwial-f2" in text
    assert "11.1 %" in text
    assert "22.2 %" in text
    assert "33.3 %" not in text
    assert mission(run_with(tmp_path), frozenset()) == ""


def test_the_mission_says_how_much_of_the_flight_was_asked(tmp_path: Path) -> None:
    asked = [
        msgspec.structs.replace(asked, demands=demands, n_demands=60, rate_hz=100.0)
        for asked, demands in (
            (problem("ukwial"), "mission"),
            (problem("ukwial-f2", whole="ukwial", fault=2), "mission-fault"),
        )
    ]
    cells = [cell(key=Key(p.vehicle, p.demands, "pinv")) for p in asked]
    text = mission(made_up.run(tmp_path, *asked, *cells), frozenset())
    assert "60 demands (0.600 s) of waypoints" in text
    asked = [msgspec.structs.replace(each, left_out=2940) for each in asked]
    text = mission(made_up.run(tmp_path, *asked, *cells), frozenset())
    assert "60 of 3,000 demands (0.600 of 30.0 s) of waypoints" in text


def test_an_axis_without_its_ends_is_refused_with_its_line(tmp_path: Path) -> None:
    short = msgspec.structs.replace(WHOLE, axis_max=[3.0])
    broken = msgspec.json.encode(CAPABILITY).replace(
        msgspec.json.encode(WHOLE), msgspec.json.encode(short), 1
    )
    path = record(tmp_path, header()) / FILE_NAME
    path.write_bytes(path.read_bytes() + broken + b"\n")
    with pytest.raises(RecordError, match="line 2: axis_min and axis_max need 3 numbers"):
        read_run(tmp_path)


def test_a_record_without_authority_or_with_an_odd_count_of_cores_is_still_shown(tmp_path: Path) -> None:
    nothing = msgspec.structs.replace(CAPABILITY, authority=[], planes=[])
    odd = header(machine={"id": "made-up", "cpu": "Example CPU", "cores": "two"})
    busy = cell(quiet=Quiet(load=9.0))
    assert "served within 1 %" in section(read_run(record(tmp_path, odd, nothing, busy)), frozenset())


def test_a_section_that_was_left_out_leaves_the_others_drawn(tmp_path: Path) -> None:
    plane = CAPABILITY.planes[0]
    loaded = [msgspec.structs.replace(plane, held_at=9.0, y=y) for y in ("sway", "yaw")]
    uneven = msgspec.structs.replace(CAPABILITY, authority=[], planes=[plane, *loaded])
    figure = pictured.reach(run_with(tmp_path, uneven), "ukwial")
    assert figure is not None
    assert len(figure.axes) == 3
