#!/usr/bin/env bash
# DAQP calls zero thrust optimal after an update with crossed limits, which it calls infeasible in one shot.
#
# Guess: a slew rate that leaves a thruster nothing makes the problem infeasible: exit flag -1, as daqp.solve says.
# Seen (daqp 0.11.0): Model.update returns -1, and solve() then has exit flag 1 and x = 0 with no constraint kept, not
#   even the equality; the wrench is missed whole. The next update with limits that don't cross is right again.
# Consequence: who looks at solve's flag alone stops all thrusters for a call that is said to be optimal. Look at
#   update's flag too.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check daqp==0.11.0 numpy
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import daqp
import numpy as np

# Three thrusters side by side make 2.4 of surge, each within 1. Its slew rate keeps the first above 1.5.
n, tau = 3, 2.4
H, f, T = np.eye(n), np.zeros(n), np.ones((1, n))
sense = np.array([0] * n + [5], dtype=np.int32)
upper, lower = np.array([1.0] * n + [tau]), np.array([-1.0] * n + [tau])
crossed = lower.copy()
crossed[0] = 1.5

model = daqp.Model()
model.setup(H, f, T, upper, lower, sense)
first = model.solve()
once = daqp.solve(H, f, T, upper, crossed, sense)
refused = model.update(bupper=upper, blower=crossed)
after = model.solve()
mended = model.update(bupper=upper, blower=lower), model.solve()
print(f"daqp {version('daqp')}: one shot flag {once[2]}; update {refused}, then flag {after[2]} with x {after[0]}")
assert first[2] == 1 and np.allclose(first[0], tau / n)
assert once[2] == refused == -1
assert after[2] == 1 and not after[0].any()
assert mended[0] == 0 and np.allclose(mended[1][0], tau / n)
PYTHON
