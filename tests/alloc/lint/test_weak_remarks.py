"""Remarks on weak directions, and the table of two failures."""

import numpy as np

from alloc import load_vehicle
from alloc.lint.check import check_vehicle
from alloc.lint.failures import failures, pairs
from alloc.lint.report import as_table
from alloc.vehicle.weak import Survey
from bench.demands.surveys import move_poses
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
