"""The report says what the vehicle's autopilot leaves undone, of a vehicle that has one."""

import re
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from alloc import alpha_max, build, load_vehicle
from alloc.vehicle.autopilot import make_autopilot, mixer_frame
from bench.judging.capability import measure_capabilities
from bench.judging.loss import relative_wrench_error
from bench.judging.mixer import mixer_cost
from bench.judging.question import ask_here
from bench.record import Capability, MixerCost
from bench.report.page import page
from bench.report.sections.mixer import mixer
from bench.results.rows import Run
from tests import made_up

N = 200


@pytest.fixture(scope="module")
def measured() -> Capability:
    (capability,) = measure_capabilities([load_vehicle("bluerov2")], ["pinv"], 0, ask_here, N)
    return capability


@pytest.fixture(scope="module")
def cost(measured: Capability) -> MixerCost:
    assert measured.mixer is not None
    return measured.mixer


def run_with(tmp_path: Path, capability: Capability) -> Run:
    problem = made_up.problem(capability.vehicle)
    cell = made_up.exact_cell(capability.vehicle, "nullspace", 1.0)
    return made_up.run(tmp_path, problem, cell, capability)


def test_the_sentence_has_the_shares_of_the_record_and_the_table_the_costliest_demands(
    tmp_path: Path, measured: Capability, cost: MixerCost
) -> None:
    text = mixer(run_with(tmp_path, measured), frozenset())
    found = re.search(
        r"\(VECTORED\) delivers ([\d.]+) % of what .* misses ([\d.]+) % .* \(`scaled`\) delivers all 200",
        text,
    )
    assert found is not None
    assert float(found[1]) == pytest.approx(100 * cost.served / N, rel=0.01)
    assert float(found[2]) == pytest.approx(100 * cost.missed_p50, rel=0.01)
    rows = re.findall(r"^\| surge .*\| +([\d.]+) % \|$", text, re.MULTILINE)
    assert [float(share) for share in rows] == pytest.approx([100 * m for m in cost.missed], rel=0.01)
    assert text in page(run_with(tmp_path, measured), frozenset())


def test_the_demands_can_be_met_and_the_wrenches_are_the_mixer_s(cost: MixerCost) -> None:
    vehicle = load_vehicle("bluerov2")
    taus = np.array(cost.demands)
    assert (alpha_max(vehicle, taus) >= 1 - 1e-6).all()
    made = build("ardusub", vehicle).many(taus)[0] @ vehicle.TP.T
    np.testing.assert_allclose(cost.wrenches, made, rtol=1e-3, atol=1e-3 * vehicle.wrench_scale.min())
    assert cost.missed == sorted(cost.missed, reverse=True)
    assert cost.exact_served == N > cost.served > 0


def test_moves_stray_with_the_mixer_where_its_factors_couple_axes_and_not_with_the_exact_answer(
    tmp_path: Path, measured: Capability, cost: MixerCost
) -> None:
    """The lateral thrusters of a BlueROV2 lie below its centre, and it can't roll against all their sway."""
    assert [move.axis for move in cost.moves] == ["surge", "sway", "heave"]
    assert [(move.off_m[1], move.turned_deg[1]) for move in cost.moves] == [(0, 0)] * 3
    assert [move.turned_deg[0] > 1 for move in cost.moves] == [False, True, False]
    rows = re.findall(
        r"^\| (surge|sway|heave) +\| ([-\d. |]+)\|$", mixer(run_with(tmp_path, measured), frozenset()), re.M
    )
    assert [[float(number) for number in row.split("|")] for _, row in rows] == [
        [*move.off_m, *move.turned_deg] for move in cost.moves
    ]


@pytest.mark.parametrize(
    ("own", "says"),
    [
        (True, "with this vehicle's inertia and a BlueROV2 Heavy's damping, weight and buoyancy in still"),
        (False, "with a BlueROV2 Heavy's body, for want of 'inertia' in the file, in still water"),
    ],
)
def test_the_moved_body_is_named(
    own: bool, says: str, tmp_path: Path, measured: Capability, cost: MixerCost
) -> None:
    assert not cost.own_inertia  # bluerov2's file says none
    moved = msgspec.structs.replace(measured, mixer=msgspec.structs.replace(cost, own_inertia=own))
    assert says in mixer(run_with(tmp_path, moved), frozenset())


def test_a_vehicle_without_an_autopilot_has_no_such_section(tmp_path: Path) -> None:
    (capability,) = measure_capabilities([load_vehicle("ukwial")], ["pinv"], 0, ask_here, 60)
    assert capability.mixer is None
    assert mixer(run_with(tmp_path, capability), frozenset()) == ""


def test_an_exact_answer_that_serves_less_than_all_has_its_share(
    tmp_path: Path, measured: Capability, cost: MixerCost
) -> None:
    less = msgspec.structs.replace(cost, exact_served=N // 2)
    text = mixer(run_with(tmp_path, msgspec.structs.replace(measured, mixer=less)), frozenset())
    assert "(`scaled`) delivers 50.0 %." in text


def test_a_cost_survives_the_record_and_one_that_lacks_a_number_is_refused(
    tmp_path: Path, measured: Capability, cost: MixerCost
) -> None:
    read = run_with(tmp_path, measured).capability("bluerov2")
    assert read is not None
    assert read.mixer == cost
    for change in ({"missed": []}, {"n_demands": 0}):
        with pytest.raises(ValueError, match=r"must not be empty|as many entries"):
            MixerCost(**(msgspec.structs.asdict(cost) | change))


def test_the_mixer_of_a_vehicle_that_px4_flies_is_px4_s() -> None:
    vehicle = load_vehicle("bluerov2")
    limits = vehicle.f_min, vehicle.f_max
    flown = replace(vehicle, autopilot=make_autopilot(mixer_frame("", "automatic"), limits))
    taus = 0.2 * vehicle.wrench_scale * np.eye(vehicle.k)
    cost = mixer_cost(flown, taus)
    assert cost is not None
    assert (cost.method, cost.frame) == ("px4", "PX4")
    missed = relative_wrench_error(flown, taus, build("px4", flown).many(taus)[0])
    assert cost.missed == pytest.approx(sorted(missed, reverse=True)[:3], rel=1e-3)


def test_what_is_missed_by_rounding_is_nothing(tmp_path: Path, measured: Capability, cost: MixerCost) -> None:
    least = msgspec.structs.replace(cost, missed_p50=4.87e-16)
    text = mixer(run_with(tmp_path, msgspec.structs.replace(measured, mixer=least)), frozenset())
    assert "It misses 0 % of a demand's wrench in the median" in " ".join(text.split())
