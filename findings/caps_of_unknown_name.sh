#!/usr/bin/env bash
# SuperADMM and DAQP's model take a cap of iterations under a wrong name without a word, and run without it.
#
# Guess: an option that a solver doesn't know raises, as it does from OSQP, SCS and daqp.solve.
# Seen (superadmm 0.7.2, daqp 0.11.0): max_iter=1, OSQP's name, changes nothing in superADMM's options, where it is called
#   maxIter, nor in the settings of daqp.Model, where it is iter_limit. Both solve to the end. daqp.solve raises TypeError.
# Consequence: a cap or a tolerance in a benchmark's table, or a worst-case time in a vehicle, was never set. Read
#   DAQP's settings back; hold superADMM's names against getOptimOpts().
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check superadmm==0.7.2
"$folder/env/bin/pip" install --quiet --disable-pip-version-check daqp==0.11.0
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import daqp
import numpy as np
from superADMM import superADMM

T = np.array(
    [
        [0.707, -0.707, -0.707, 0.707, 1.0, 0.0],
        [0.707, 0.707, -0.707, -0.707, 0.0, 1.0],
        [0.071, 0.071, 0.495, 0.495, -0.25, 0.2],
    ]
)
k, n = T.shape
H, g, tau = np.eye(n), np.zeros(n), np.array([-1.6135, -2.2791, 0.6522])
rows = np.asfortranarray(np.vstack([T, np.eye(n)]))
low, high = np.r_[tau, -np.ones(n)], np.r_[tau, np.ones(n)]


def by_superadmm(**options):
    *_, flag, info = superADMM(np.asfortranarray(H), g, rows, low, high, None, None, {"verbose": 0, **options})
    return flag, info["nIter"]


def by_daqp(**options):
    model = daqp.Model()
    model.settings = options
    model.setup(H, g, T, np.r_[high[k:], tau], np.r_[low[k:], tau], np.array([0] * n + [5] * k, dtype=np.int32))
    _, _, flag, info = model.solve()
    return flag, info["iterations"]


versions = f"superadmm {version('superadmm')}, daqp {version('daqp')}"
for solve, name in ((by_superadmm, "maxIter"), (by_daqp, "iter_limit")):
    free, capped, unknown = solve(), solve(**{name: 1}), solve(max_iter=1)
    print(f"{versions}: {solve.__name__}: (flag, iterations) without {free}, {name}=1 {capped}, max_iter=1 {unknown}")
    assert free[0] == 1 and free[1] > 1 and capped[0] != 1
    assert unknown == free
try:
    daqp.solve(H, g, T, np.r_[high[k:], tau], np.r_[low[k:], tau], max_iter=1)
except TypeError as error:
    print(f"daqp.solve: {error}")
else:
    raise SystemExit("daqp.solve takes max_iter: this has changed")
PYTHON
