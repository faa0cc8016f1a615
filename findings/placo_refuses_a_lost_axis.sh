#!/usr/bin/env bash
# PlaCo finds no thrusts for a BlueROV2's six rows, of which no thruster pushes one, unless a default is changed.
#
# Guess: hard equations that agree, one of them 0 = 0, cost nothing but a row: other solvers drop it or solve anyway.
# Seen (placo 0.10.2): each of 100 demands that thrusts within limits make ends in a QPError, whose word is of a
#   decomposition without full rank; so does a row that is the sum of two others. Without that row all are solved. With
#   rewrite_equalities = False all three are, to 1e-13.
# Consequence: leave out axes that no thruster pushes (pitch here), or switch rewrite_equalities off. It is no word about
#   the demand: one beyond reach ends in an error of its own.
# Source of T: the layout of a six-thruster ROV of the BlueROV2's kind, arms rounded.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check placo==0.10.2
"$folder/env/bin/python" - <<'PYTHON'
from collections import Counter

import numpy as np
from placo import Problem

T = np.array(
    [
        [0.707, 0.707, -0.707, -0.707, 0, 0],
        [-0.707, 0.707, -0.707, 0.707, 0, 0],
        [0, 0, 0, 0, -1, -1],
        [0, 0, 0, 0, -0.11, 0.11],
        [0, 0, 0, 0, 0, 0],
        [-0.19, 0.19, 0.19, -0.19, 0, 0],
    ]
)
KEPT = T[[0, 1, 2, 3, 5]]
LIMIT = np.full(6, 40.0)


def answer(rows, tau, **settings):
    problem = Problem()
    for name, value in settings.items():
        setattr(problem, name, value)
    f = problem.add_variable(6)
    problem.add_constraint(f.expr().left_multiply(rows) == tau)
    problem.add_constraint(f.expr() <= LIMIT)
    problem.add_constraint(f.expr() >= -LIMIT)
    try:
        problem.solve()
    except Exception as error:
        return "full rank" if "full rank" in str(error) else "beyond" if "nfeasible" in str(error) else str(error)
    return "solved" if np.abs(rows @ f.value - tau).max() < 1e-9 else "wrong"


rng = np.random.default_rng(0)
thrusts = rng.uniform(-40, 40, (100, 6))
cases = {
    "six rows": (T, {}),
    "a sum of two": (np.vstack([KEPT, KEPT[0] + KEPT[2]]), {}),
    "five rows": (KEPT, {}),
    "six rows, not rewritten": (T, {"rewrite_equalities": False}),
    "a sum of two, not rewritten": (np.vstack([KEPT, KEPT[0] + KEPT[2]]), {"rewrite_equalities": False}),
}
found = {name: Counter(answer(rows, rows @ f, **settings) for f in thrusts) for name, (rows, settings) in cases.items()}
far = Counter(answer(KEPT, KEPT @ f / np.abs(KEPT @ f).max() * 1e3) for f in thrusts)
for name, counts in [*found.items(), ("five rows, far beyond", far)]:
    print(f"placo 0.10.2, {name}: {dict(counts)}")
assert [set(counts) for counts in found.values()] == [{"full rank"}] * 2 + [{"solved"}] * 3
assert set(far) == {"beyond"}
PYTHON
