#!/usr/bin/env bash
# Clarabel says Solved with thrusts that miss the wrench where one limit is 1e19, which stands for "none" elsewhere.
#
# Guess: a huge limit for one thruster is as good as none; IPOPT takes 1e19 and more for infinite.
# Seen (clarabel 0.11.1): infinite is 1e20 and more here. With 1e19 its tolerances are relative to that number: 49 of 50
#   attainable demands are Solved, and up to 104 of 104 N of a wrench are missed. With 1e15 none is Solved, with 1e20
#   and with inf all are, to 1e-11 N.
# Consequence: one limit that is a placeholder turns every answer to nothing, with a good status. Give inf.
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check clarabel==0.11.1
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import clarabel
import numpy as np
from scipy import sparse

T = np.array(
    [
        [0.707, -0.707, -0.707, 0.707, 1.0, 0.0],
        [0.707, 0.707, -0.707, -0.707, 0.0, 1.0],
        [0.071, 0.071, 0.495, 0.495, -0.25, 0.2],
    ]
)
k, n = T.shape
P, A = sparse.eye(n, format="csc"), sparse.csc_matrix(np.vstack([T, np.eye(n), -np.eye(n)]))
cones = [clarabel.ZeroConeT(k), clarabel.NonnegativeConeT(2 * n)]
settings = clarabel.DefaultSettings()
settings.verbose = False
rng = np.random.default_rng(0)
demands = [T @ rng.uniform(-40.0, 40.0, n) for _ in range(50)]


def solved(limit):
    """Number of demands Solved, and the largest miss of their wrenches [N, N m]."""
    count, missed = 0, 0.0
    for tau in demands:
        b = np.concatenate([tau, [limit], np.full(n - 1, 40.0), np.full(n, 40.0)])
        answer = clarabel.DefaultSolver(P, np.zeros(n), A, b, cones, settings).solve()
        if str(answer.status) == "Solved":
            count, missed = count + 1, max(missed, float(np.abs(T @ np.array(answer.x) - tau).max()))
    return count, missed


found = {limit: solved(limit) for limit in (1e12, 1e15, 1e19, 1e20, np.inf)}
print(f"clarabel {version('clarabel')}: (Solved of 50, largest miss) by the limit: {found}")
assert found[1e15][0] == 0
assert found[1e19][0] > 40 and found[1e19][1] > 50.0
for limit in (1e12, 1e20, np.inf):
    assert found[limit][0] == 50 and found[limit][1] < 1e-5
PYTHON
