"""Remarks on weak directions, and the table of two failures."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.lint.check import check_vehicle
from alloc.lint.failures import failures, on_failures, on_weak, pairs, weak_axes
from alloc.lint.report import as_table
from alloc.vehicle.weak import WEAK, Survey
from bench.demands.surveys import fail_thrusters, move_poses
from tests.places import DOCS


def test_a_weak_axis_is_named_with_its_share_and_what_methods_do() -> None:
    report = check_vehicle(DOCS / "vehicles/bluerov2-surveyed.yaml")
    (weak,) = [finding.message for finding in report.findings if finding.key == "weak"]
    assert weak.startswith("pitch: 0.5 % of yaw, less than a survey of 3 mm, 0.3 deg can make; scaled and")
    without = [finding.message for finding in report.findings if finding.message.startswith("without")]
    assert without[0] == (
        "without thruster5 or thruster6: no heave and roll together (the file promises 0.7 %,"
        " the survey does not)"
    )
    assert without[1].startswith("without thruster1 or thruster2: surge 5")
    assert "two off  thruster5 + thruster6: no " in as_table(report)


def test_pairs_that_sink_or_roll_a_vehicle_come_first_and_a_survey_changes_none() -> None:
    heavy = load_vehicle("bluerov2-heavy")
    drawn = [pair.words for pair in pairs(heavy)]
    assert drawn[0] == "4 + 5, 6 + 7: no heave and pitch together"
    assert drawn[-1] == "0 + 3, 1 + 2: no surge and sway together"
    found = pairs(move_poses(heavy, Survey(), np.random.default_rng(1)))
    assert [(pair.names, pair.lost) for pair in found] == [(pair.names, pair.lost) for pair in pairs(heavy)]
    assert all(0.0 < pair.weak < 0.04 for pair in found)
    assert not any(failure.lost for failure in failures(heavy))


def in_part(vehicle: Vehicle, off: tuple[int, ...], counts: float) -> Vehicle:
    """The vehicle with a survey by which its least direction, with thrusters off, counts by so much."""
    found = fail_thrusters(vehicle, off).directions
    times = float((found.sigma / found.epsilon).min()) / (WEAK * (1.0 + counts))
    return replace(vehicle, survey=Survey(times * vehicle.survey.mm, times * vehicle.survey.deg))


def test_a_direction_that_counts_in_part_is_named_with_how_much(tmp_path: Path) -> None:
    surveyed = load_vehicle(DOCS / "vehicles/bluerov2-surveyed.yaml")
    found = surveyed.directions
    low = float(found.sigma[-1] / found.sigma[0]) / 1.4
    (plain,) = on_weak(replace(surveyed, weak_limit=low))
    assert plain[2].startswith(
        f"pitch: 0.5 % of yaw, 1.4 times what 'weak: {low:g}' asks for; scaled and priority count it by 40 %"
    )
    text = (DOCS / "vehicles/bluerov2-surveyed.yaml").read_text(encoding="utf-8")
    (tmp_path / "rov.yaml").write_text(f"{text}\nweak: {low:.6g}\n", encoding="utf-8")
    (said,) = [each.message for each in check_vehicle(tmp_path / "rov.yaml").findings if each.key == "weak"]
    assert "count it by 40 %" in said
    times = in_part(surveyed, (), 0.25)
    assert [each.counts for each in weak_axes(times)] == pytest.approx([0.25])
    assert "scaled and priority count it by 25 %" in next(iter(on_weak(times)))[2]


def test_failures_that_make_a_direction_count_in_part_say_so() -> None:
    """One thruster and two; of pairs that cost the same, the table names the least share."""
    heavy = move_poses(load_vehicle("bluerov2-heavy"), Survey(), np.random.default_rng(1))
    two = in_part(heavy, (4, 5), 0.4)
    (found,) = [pair for pair in pairs(two) if ("thruster 4", "thruster 5") in pair.names]
    assert found.lost == ()
    assert list(found.in_part) == ["heave and pitch together"]
    assert found.in_part["heave and pitch together"] <= 0.4 + 1e-9
    assert f"heave and pitch together counted by {100 * min(found.in_part.values()):.0f} %" in found.words
    one = in_part(fail_thrusters(heavy, (4,)), (5,), 0.4)
    (failure,) = [each for each in failures(one) if each.thruster == 5]
    assert failure.in_part == pytest.approx({"heave and pitch together": 0.4})
    assert failure.words.startswith("heave and pitch together counted by 40 %, ")
    said = [level for level, _, words in on_failures([failure], 1.0) if "counted by 40 %" in words]
    assert said == ["warning"]
