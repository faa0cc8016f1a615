#!/usr/bin/env bash
# OSQP keeps the old lower limits where lower and upper limits are updated one after the other.
#
# Guess: update(l=...) followed by update(u=...) is the same as update(l=..., u=...), or the first one raises.
# Seen (osqp 1.1.3): new lower limits above the old upper ones are refused with a line on the terminal and no exception;
#   update returns None both ways. The second call is taken, and solve says "solved" with the old lower limits.
# Consequence: limits that move by more than their width, as slew rates make them, give thrusts outside the limits of
#   the call with a good status. Update both in one call.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check osqp==1.1.3
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import numpy as np
import osqp
from scipy import sparse

# Two thrusters side by side: surge f0 + f1 between 0 and 40 N, each thruster within its own limits.
A = sparse.csc_matrix([[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])
before = np.array([0.0, -8.0, -8.0]), np.array([40.0, 8.0, 8.0])
after = np.array([0.0, 9.0, 9.0]), np.array([40.0, 12.0, 12.0])


def solved(*updates):
    solver = osqp.OSQP()
    tolerance = {"eps_abs": 1e-8, "eps_rel": 1e-8, "verbose": False}
    solver.setup(sparse.eye(2, format="csc"), np.zeros(2), A, *before, **tolerance)
    solver.solve()
    returned = [solver.update(**each) for each in updates]
    result = solver.solve()
    return result.info.status, result.x, returned


together = solved({"l": after[0], "u": after[1]})
apart = solved({"l": after[0]}, {"u": after[1]})
print(f"osqp {version('osqp')}: together {together}, one after the other {apart}")
assert together[0] == apart[0] == "solved" and apart[2] == [None, None]
assert np.abs(together[1] - 9.0).max() < 1e-5
assert apart[1].max() < 9.0 - 1.0
PYTHON
