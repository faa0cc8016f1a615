"""The right answers that methods are held to, at the edge of what a vehicle can do."""

from pathlib import Path

import numpy as np
import pytest

from alloc import build, load_vehicle
from bench.demands import build_demands
from bench.judging.question import Question, ask_here, questions, right_answers

LEANING = """\
name: leaning
dof: [surge, sway, heave, roll, pitch, yaw]
thrusters:
  - {position: [0.33, -0.28, 0.05], direction: [0.766044443118978, 0.6427876096865393, 0]}
  - {position: [0.33, 0.28, 0.05], direction: [0.766044443118978, -0.6427876096865393, 0]}
  - {position: [-0.37, -0.25, 0.03], direction: [0.766044443118978, -0.6427876096865393, 0]}
  - {position: [-0.37, 0.25, 0.03], direction: [0.766044443118978, 0.6427876096865393, 0]}
  - {position: [0.22, -0.31, 0], direction: [0.17364817766693033, 0, 0.984807753012208]}
  - {position: [0.22, 0.31, 0], direction: [0.17364817766693033, 0, 0.984807753012208]}
  - {position: [-0.24, -0.29, 0], direction: [0, 0, 1]}
  - {position: [-0.24, 0.29, 0], direction: [0, 0, 1]}
center_of_mass: [0.01, 0, -0.03]
f_min: -38
f_max: 50
"""
"""Two of the upright thrusters lean 10 degrees ahead."""


@pytest.mark.parametrize("method", ["scaled", "scaled-by-group", "priority"])
def test_the_right_answer_at_an_edge_is_that_of_the_demand_and_of_none_beside_it(
    method: str, tmp_path: Path
) -> None:
    """References are asked a little inside, where the right thrusts of this vehicle are 4e-9 away.

    Right answers were called wrong, and the verdict took a method without limits.
    """
    path = tmp_path / "leaning.yaml"
    path.write_text(LEANING)
    vehicle = load_vehicle(path)
    demands = build_demands("infeasible", vehicle, 0, 100)
    (question,) = questions([demands], ask_here)
    allocator = build(method, vehicle)
    F, _ = allocator.many(demands.taus)
    apart = np.abs(F - right_answers(question, allocator.formulation)).max() / vehicle.f_scale
    assert apart < 0.1 * allocator.tolerance


def test_a_question_is_read_back_as_saved_with_a_vehicle_that_shares_no_array(
    tmp_path: Path,
) -> None:
    vehicle = load_vehicle("ukwial")
    (question,) = questions([build_demands("active", vehicle, 0, 3)], ask_here)
    question.save(tmp_path / "question.npz")
    asked, given = Question.load(tmp_path / "question.npz")
    judged = asked.demands.vehicle
    assert (judged.name, judged.dof, asked.demands.rate_hz) == ("ukwial", vehicle.dof, None)
    np.testing.assert_array_equal(asked.demands.taus, question.demands.taus)
    np.testing.assert_array_equal(asked.right["hard"], question.right["hard"])
    for name in ("T", "H", "f_min", "f_max", "readiness", "slack_weights"):
        own, other = getattr(given, name), getattr(judged, name)
        np.testing.assert_array_equal(own, getattr(vehicle, name))
        np.testing.assert_array_equal(own, other)
        assert not np.shares_memory(own, other)
