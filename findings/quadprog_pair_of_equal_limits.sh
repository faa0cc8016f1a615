#!/usr/bin/env bash
# quadprog finds no solution for some demands where a thruster that is off is given equal limits.
#
# Guess: lb = ub = 0 for a thruster that is off is the same problem as one without that thruster.
# Seen (quadprog 0.1.14 through qpsolvers 4.13.0): equal limits reach it as two opposite inequalities, and 28 of 1,000
#   attainable demands are "inconsistent". Without the column, with an equality in place of the pair, or with limits
#   of -1e-9 and 1e-9, all 1,000 are solved.
# Consequence: a demand is refused after a failure that the remaining thrusters can make, and the refusal looks like
#   one of the limits. Leave the column out, or give an equality.
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check quadprog==0.1.14
"$folder/env/bin/pip" install --quiet --disable-pip-version-check qpsolvers==4.13.0
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import numpy as np
from qpsolvers import Problem, solve_problem

T = np.array(
    [
        [0.707, -0.707, -0.707, 0.707, 1.0, 0.0],
        [0.707, 0.707, -0.707, -0.707, 0.0, 1.0],
        [0.071, 0.071, 0.495, 0.495, -0.25, 0.2],
    ]
)
n, off, limit = 6, 2, 40.0
others = [i for i in range(n) if i != off]
low, high = np.full(n, -limit), np.full(n, limit)


def is_found(A, tau, lb, ub):
    m = len(lb)
    return bool(solve_problem(Problem(np.eye(m), np.zeros(m), None, None, A, tau, lb, ub), "quadprog").found)


def pinned(width):
    lb, ub = low.copy(), high.copy()
    lb[off], ub[off] = -width, width
    return lb, ub


rng = np.random.default_rng(0)
found = dict.fromkeys(("equal limits", "no column", "equality", "1e-9 apart"), 0)
for _ in range(1000):
    f = rng.uniform(low, high)
    f[off] = 0.0
    tau = T @ f
    found["equal limits"] += is_found(T, tau, *pinned(0.0))
    found["no column"] += is_found(T[:, others], tau, low[others], high[others])
    found["equality"] += is_found(np.vstack([T, np.eye(n)[off]]), np.append(tau, 0.0), low, high)
    found["1e-9 apart"] += is_found(T, tau, *pinned(1e-9))
print(f"quadprog {version('quadprog')}, qpsolvers {version('qpsolvers')}: solved of 1000: {found}")
assert found.pop("equal limits") < 990
assert set(found.values()) == {1000}
PYTHON
