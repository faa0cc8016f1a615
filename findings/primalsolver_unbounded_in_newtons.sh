#!/usr/bin/env bash
# PrimalSolver calls a strictly convex QP between finite limits unbounded in newtons, and solves it as fractions.
#
# Guess: limits of 250 (newtons) are well scaled enough for a convex QP of four variables and three equations.
# Seen (primalsolver 0.1.3, whose library says 0.1.0): of 100 demands that can be met, one thrust at its limit,
#   11 are UNKNOWN and 4 have a certificate of dual infeasibility. Divided by 250 the same are all OPTIMAL.
# Consequence: its certificates prove nothing in newtons; give it fractions of the largest limit.
# Source of T: four horizontal thrusters of a small ROV, angles and arms rounded.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check primalsolver==0.1.3 numpy
"$folder/env/bin/python" - <<'PYTHON'
from collections import Counter

import numpy as np
from primalsolver import BK, SOLSTA, Model, version

T = np.array([[0.875, 0.875, -0.875, -0.875], [0.485, -0.485, 0.485, -0.485], [0.332, -0.332, -0.332, 0.332]])
K, N, LIMIT = 3, 4, 250.0


def status(tau, limit):
    with Model(maxcon=K, maxvar=N) as model:
        model.obj(list(range(N)), [0.0] * N)
        for i in range(N):
            model.qobj_ij(i, i, 1.0)
            model.var_bounds(i, BK.RA, -limit, limit)
        for j in range(K):
            for i in range(N):
                model.a_ij(j, i, float(T[j, i]))
            model.con_bounds(j, BK.FX, float(tau[j]), float(tau[j]))
        return model.solve().solsta


rng = np.random.default_rng(0)
thrusts = rng.uniform(-0.95, 0.95, (100, N))
thrusts[np.arange(100), rng.integers(N, size=100)] = rng.choice([-1.0, 1.0], 100)  # one at its limit
counts = {unit: Counter(status(T @ f * LIMIT / unit, LIMIT / unit) for f in thrusts) for unit in (1.0, LIMIT)}
names = {value: name for name, value in vars(SOLSTA).items() if isinstance(value, int)}
for unit, found in counts.items():
    print(f"primalsolver 0.1.3 (library {version()}), unit {unit:g} N:", {names.get(each, each): n for each, n in found.items()})
assert counts[1.0][SOLSTA.OPTIMAL] <= 90
assert counts[1.0][SOLSTA.DUAL_INFEAS_CER] >= 1
assert counts[LIMIT][SOLSTA.OPTIMAL] == 100
PYTHON
