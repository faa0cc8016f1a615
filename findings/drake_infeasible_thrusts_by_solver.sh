#!/usr/bin/env bash
# Drake's thrusts for a demand beyond reach are zero, two billion, NaN or limits, by the solver that it took.
#
# Guess: one toolbox, one convention: where a program has no solution, GetSolution gives NaN, and the cost is infinite.
# Seen (drake 1.51.1): of 50 demands at twice what the limits allow all solvers say kInfeasibleConstraints. GetSolution
#   then gives NaN with SCS only; with Clarabel, which Solve takes by itself, less than 1e-4 N (a certificate: it looks
#   like rest); with OSQP 1e8 N and more; with SNOPT thrusts at their limits, and a cost of 0.
# Consequence: ask is_success() before GetSolution, each time; no test of the thrusts can stand in for it.
# Source of T: eight thrusters of an ROV of the BlueROV2 Heavy's kind, arms rounded.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check drake==1.51.1 scipy==1.17.1
"$folder/env/bin/python" - <<'PYTHON'
import logging

import numpy as np
from pydrake.solvers import (
    ClarabelSolver,
    MathematicalProgram,
    OsqpSolver,
    ScsSolver,
    SnoptSolver,
    Solve,
    SolutionResult,
)
from scipy.optimize import linprog

logging.getLogger("drake").setLevel(logging.ERROR)
T = np.array(
    [
        [0.707, 0.707, -0.707, -0.707, 0, 0, 0, 0],
        [-0.707, 0.707, -0.707, 0.707, 0, 0, 0, 0],
        [0, 0, 0, 0, -1, 1, 1, -1],
        [0, 0, 0, 0, -0.218, -0.218, 0.218, 0.218],
        [0, 0, 0, 0, 0.12, -0.12, 0.12, -0.12],
        [-0.1888, 0.1888, 0.1888, -0.1888, 0, 0, 0, 0],
    ]
)
LOW, HIGH = np.full(8, -40.0), np.full(8, 50.0)


def beyond(direction):
    """Twice the largest wrench along a direction, by a linear program."""
    columns, bounds = np.c_[T, -direction], [*zip(LOW, HIGH), (0, None)]
    return 2 * linprog(np.r_[np.zeros(8), -1], A_eq=columns, b_eq=np.zeros(6), bounds=bounds).x[-1] * direction


def program(tau):
    made = MathematicalProgram()
    f = made.NewContinuousVariables(8)
    made.AddQuadraticCost(np.eye(8), np.zeros(8), f, is_convex=True)
    made.AddLinearEqualityConstraint(T, tau, f)
    made.AddBoundingBoxConstraint(LOW, HIGH, f)
    return made, f


rng = np.random.default_rng(0)
demands = [beyond(T @ rng.uniform(LOW, HIGH)) for _ in range(50)]
largest, costs = {}, {}
for solver in (ClarabelSolver(), OsqpSolver(), ScsSolver(), SnoptSolver()):
    name = type(solver).__name__
    results = []
    for tau in demands:
        made, f = program(tau)
        result = solver.Solve(made)
        assert result.get_solution_result() == SolutionResult.kInfeasibleConstraints
        results.append((np.abs(result.GetSolution(f)).max(), result.get_optimal_cost()))
    largest[name], costs[name] = (np.array(column) for column in zip(*results))
    sizes, counts = np.unique(costs[name], return_counts=True)
    print(f"drake 1.51.1, {name}: largest thrust {largest[name].min():.3g} to {largest[name].max():.3g} N, costs {set(sizes)}")
assert Solve(program(demands[0])[0]).get_solver_id().name() == "Clarabel"
assert np.isnan(largest["ScsSolver"]).all()
assert (largest["ClarabelSolver"] < 1e-4).all()
assert (largest["OsqpSolver"] > 1e8).all()
assert np.allclose(largest["SnoptSolver"], 50) and (costs["SnoptSolver"] == 0).all()
PYTHON
