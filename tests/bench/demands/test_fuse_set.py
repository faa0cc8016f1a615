"""Demands drawn to a cap: what it leaves of each, by labels, methods, and the judge of a run."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from alloc import Label, NotApplicable, build, load_vehicle
from alloc.allocation import answer
from alloc.vehicle.current import Cap
from bench.demands import DemandSet, Supply, build_demands
from bench.harness.plan import RunSettings
from bench.harness.run import run
from bench.judging.judge import judge
from bench.judging.question import ask_here, questions
from bench.record.file import read

VEHICLE = replace(load_vehicle("bluerov2-heavy"), name="fused", cap=Cap(25.0, 3.0, volts=12.0))


@cache
def drawn() -> DemandSet:
    return build_demands("fuse", VEHICLE, 1, 12)


def test_alpha_is_the_largest_share_that_any_method_delivers_and_lies_on_both_sides_of_1() -> None:
    demands, frugal = drawn(), build("frugal", VEHICLE)
    low, high = demands.limits
    assert demands.supply == Supply(22.0, 12.0)
    assert {Label.INACTIVE, Label.INFEASIBLE} <= set(demands.labels)
    for tau, f_min, f_max, alpha in zip(demands.taus, low, high, demands.alpha, strict=True):
        share = frugal(tau, f_min, f_max, cap=22.0, volts=12.0).share[0]
        assert share == pytest.approx(min(alpha, 1.0), abs=1e-6)


def test_least_effort_beyond_the_cap_makes_no_demand_inactive() -> None:
    demands, pinv = drawn(), build("pinv", VEHICLE)
    F, _ = pinv.many(demands.taus)
    within = VEHICLE.draw(12.0).amps(F).sum(axis=1) <= 22.0
    inside = ((demands.limits[0] <= F) & (demands.limits[1] >= F)).all(axis=1)
    certain = np.abs(demands.alpha - 1.0) > 0.01
    inactive = demands.labels == Label.INACTIVE
    np.testing.assert_array_equal(inactive[certain], (within & inside)[certain])


def test_an_answer_that_draws_more_than_the_cap_is_wrong_and_one_within_it_is_not() -> None:
    (question,) = questions([drawn()], ask_here)
    promises = {"formulation": "scaled", "limited": True, "tolerance": 1e-9}
    allocate, calls = (
        build("scaled", VEHICLE),
        list(zip(question.demands.taus, *question.demands.limits, strict=True)),
    )
    within = [allocate(*call, cap=22.0, volts=12.0) for call in calls]
    assert judge(question, within, **promises).wrong == ""
    beyond = [
        answer(1.0 * one.f, one.status, share=one.share) for one in map(allocate, *zip(*calls, strict=True))
    ]
    assert "draws more current than the cap" in judge(question, beyond, **promises).wrong


def test_a_run_times_methods_under_the_cap_and_those_without_refuse(tmp_path: Path) -> None:
    file = tmp_path / "fused.yaml"
    file.write_text(
        "name: fused\ndof: [surge, sway, yaw]\nplanar: {alpha_deg: [29, -29, 151, -151], d: [1, 1, 1, 1],"
        " phi_deg: [119, -119, 61, -61]}\nf_min: -30\nf_max: 30\nsource: a test\n"
        "esc: {neutral: 1500, range: [1100, 1900], dead_band: jump, curve: t200, volts: 12}\n"
        "cap: {amps: 10}\n"
    )
    asked = ("scaled", "nullspace")
    run(
        RunSettings(
            vehicles=(str(file),), methods=asked, demands=("fuse",), n_demands=8, repeats=1, budget_ms=1.0
        ),
        tmp_path / "out",
        resume=False,
        watch=lambda _: None,
    )
    record = read(tmp_path / "out")
    cells = {cell.key.method: cell for cell in record.cells}
    assert record.problems[0].cap_A == 10.0
    judged = cells["scaled"].judged
    assert judged is not None
    assert (cells["scaled"].status, judged.wrong) == ("ok", "")
    assert judged.share_min[0] < 1.0
    assert cells["nullspace"].status == "refused"
    assert "cap: methods for 'hard' take none" in cells["nullspace"].reason


def test_a_vehicle_without_a_cap_or_with_watts_and_no_voltage_has_no_such_demands() -> None:
    with pytest.raises(NotApplicable, match="has no cap; add 'cap' to its file"):
        build_demands("fuse", replace(VEHICLE, cap=None), 1, 5)
    with pytest.raises(NotApplicable, match="since the cap is in watts"):
        build_demands("fuse", replace(VEHICLE, cap=Cap(300.0, of_power=True)), 1, 5)
