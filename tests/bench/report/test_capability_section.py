"""The section on what vehicles can do: every number in it comes from the record's worth lines."""

from pathlib import Path

import msgspec

from bench.record import Cell, Judged, Key
from bench.record.capability import Authority, Curve, Plane, Served, Worth
from bench.report import mission
from bench.report.pictures import error, reach
from bench.report.worth import section
from bench.results.rows import Run, read_run
from tests.made_up import cell, header, problem, record

WHOLE = Authority(None, "ukwial", 3, 1.0, 1.0, 0.625, 0.555, [-3.0, -2.0, -1.0], [3.0, 2.0, 1.0])
BOX = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
WORTH = Worth(
    vehicle="ukwial",
    dof=["surge", "sway", "yaw"],
    authority=[
        WHOLE,
        msgspec.structs.replace(WHOLE, fault=0, condition=4321.0, volume_share=0.25),
        msgspec.structs.replace(WHOLE, fault=1, rank=2, condition=None, volume_share=0.0),
    ],
    served=[
        Served(None, "pinv", "unlimited", 2000, (0.5, 0.48, 0.52), (0.6, 0.58, 0.62)),
        Served(None, "svd", "unlimited", 2000, (0.5, 0.48, 0.52), (0.6, 0.58, 0.62)),
        Served(None, "scaled", "scaled", 2000, (1.0, 0.998, 1.0), (1.0, 0.998, 1.0)),
    ],
    curves=[
        Curve("pinv", "unlimited", [0.5, 1.0, 2.0], [0.0, 0.2, 0.6], [0.0, 0.3, 0.7]),
        Curve("svd", "unlimited", [0.5, 1.0, 2.0], [0.0, 0.2, 0.6], [0.0, 0.3, 0.7]),
        Curve("scaled", "scaled", [0.5, 1.0, 2.0], [0.0, 0.0, 0.5], [0.0, 0.0, 0.5]),
    ],
    planes=[Plane("surge", "sway", "yaw", 0.0, BOX, BOX, [(0.5, 0.5, "active")])],
)


def run_with(tmp_path: Path, *worths: Worth) -> Run:
    return read_run(record(tmp_path, header(), *worths, cell()))


def test_authority_and_shares_stand_in_the_report(tmp_path: Path):
    text = section(run_with(tmp_path, WORTH), frozenset())
    assert "62.5 %" in text
    assert "55.5 %" in text
    assert "-3.00 … 3.00" in text
    assert "50.0 % (48.0 … 52.0)" in text


def test_lost_rank_and_nearly_singular_remainders_are_pointed_out(tmp_path: Path):
    text = section(run_with(tmp_path, WORTH), frozenset())
    assert "**Lost rank**: without thruster 1" in text
    assert "**Nearly singular** with thruster 0 off" in text


def test_methods_that_serve_the_same_share_a_line_and_the_best_comes_first(tmp_path: Path):
    lines = section(run_with(tmp_path, WORTH), frozenset()).splitlines()
    served = [line.split("|")[1].strip() for line in lines if line.startswith("|") and "998" not in line]
    assert "pinv, svd" in served
    order = [line for line in lines if "scaled" in line or "pinv, svd" in line]
    assert "scaled" in order[0]


def test_a_record_without_worth_has_no_such_section_and_no_such_pictures(tmp_path: Path):
    run = run_with(tmp_path)
    assert section(run, frozenset()) == ""
    assert reach.draw(run, "ukwial") is None
    assert error.draw(run, "ukwial") is None


def test_pictures_are_drawn_and_curves_that_coincide_share_a_line(tmp_path: Path):
    run = run_with(tmp_path, WORTH)
    drawn = reach.draw(run, "ukwial")
    assert drawn is not None
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == [
        "attainable",
        "closed form inside the limits",
        "mission, active",
    ]
    drawn = error.draw(run, "ukwial")
    assert drawn is not None
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == ["scaled", "pinv, svd"]


def test_a_flight_through_a_failure_shows_before_and_after(tmp_path: Path):
    def flown(vehicle: str, demands: str, lost: float) -> Cell:
        loss: dict[str, float | None] = {"wrench_error_rel_max": lost, "answered_share": 1.0}
        loss |= {"within_1pct_share": 0.5, "direction_error_max_deg": 3.0}
        judged = Judged(10, {"SOLVED": 10}, [0.0], agrees=True, loss=loss)
        return cell("clip", key=Key(vehicle, demands, "clip"), judged=judged)

    cells = [
        flown("ukwial", "mission", 0.111),
        flown("ukwial-f2", "mission-fault", 0.222),
        flown("ukwial-f2-f0", "mission-fault", 0.333),  # the flight of another vehicle, ukwial-f2
    ]
    text = mission.section(read_run(record(tmp_path, header(), *cells)), frozenset())
    assert "### ukwial, then ukwial-f2" in text
    assert "11.1 %" in text
    assert "22.2 %" in text
    assert "33.3 %" not in text
    assert mission.section(run_with(tmp_path), frozenset()) == ""


def test_the_mission_says_how_much_of_the_flight_was_asked(tmp_path):
    asked = [
        msgspec.structs.replace(problem(vehicle, 4), demands=demands, n_demands=60, rate_hz=100.0)
        for vehicle, demands in (("ukwial", "mission"), ("ukwial-f2", "mission-fault"))
    ]
    cells = [cell(key=Key(p.vehicle, p.demands, "pinv")) for p in asked]
    text = mission.section(read_run(record(tmp_path, header(), *asked, *cells)), frozenset())
    assert "60 demands (0.600 s) of waypoints" in text
