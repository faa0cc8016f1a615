#!/usr/bin/env bash
# DAQP forgets how its soft rows are weighted, and measures a miss in a unit that the weights of thrusters choose.
#
# Guess: soft rows, and rows of one level, are missed by least squares of the rows as given; a row times 100 counts more.
# Seen (daqp 0.11.0): a row times 1, 100 or 0.01 gives one and the same answer. It is the least-squares one for rows
#   that have been given unit length in the metric of H, so other weights of thrusters move the wrench that is made.
# Consequence: axes can't be weighted by their rows. Put a slack variable with its weight in H beside each axis instead.
# T and demand are made up.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check daqp==0.11.0 numpy scipy
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import daqp
import numpy as np
from scipy.optimize import lsq_linear

T = np.array([[1.0, 1.0, 0.2, -0.3], [0.1, -0.2, 1.0, 0.9], [0.3, -0.2, -0.1, 0.2]])
tau, limit = np.array([140.0, -100.0, -60.0]), np.full(4, 40.0)
SOFT = 8


def least_squares(rows):
    return T @ lsq_linear(rows[:, None] * T, rows * tau, (-limit, limit), method="bvls", tol=1e-13).x


def by_daqp(rows, H, levels):
    high, low = np.append(limit, rows * tau), np.append(-limit, rows * tau)
    sense = np.array([0] * 4 + [0 if levels else SOFT] * 3, dtype=np.intc)
    ends = np.array([4, 7], dtype=np.intc) if levels else None
    f, _, flag, _ = daqp.solve(H, np.zeros(4), rows[:, None] * T, high, low, sense, ends)
    assert flag > 0
    return T @ f


for H in (np.eye(4), np.diag([1.0, 9.0, 1.0, 9.0])):
    unit = 1 / np.linalg.norm(T / np.sqrt(np.diag(H)), axis=1)
    for weight in (0.01, 1.0, 100.0):
        rows = np.array([1.0, 1.0, weight])
        for levels in (False, True):
            made = by_daqp(rows, H, levels)
            print(f"daqp {version('daqp')}, H {np.diag(H)}, third row x {weight:g}, levels {levels}: {made.round(1)}")
            np.testing.assert_allclose(made, least_squares(unit), atol=1e-2)
assert np.abs(least_squares(np.array([1, 1, 100.0])) - least_squares(np.ones(3))).max() > 1
assert np.abs(by_daqp(np.ones(3), np.eye(4), True) - by_daqp(np.ones(3), H, True)).max() > 0.5
PYTHON
