#!/usr/bin/env bash
# DAQP's model reads the limits from the caller's arrays again when only the cost is updated.
#
# Guess: Model.setup copies what it is given, as it does H, f and A, and update(f=...) leaves the limits as they were.
# Seen (daqp 0.11.0): the arrays bupper and blower are kept, not copied. Where the caller has filled them anew, solve()
#   still takes the old limits, but after update(f=...), which names no limits, the new ones hold, with exit flag 1.
# Consequence: one work array for two vehicles gives the first one the second one's limits, thrusts of 2.8 where 1 is
#   the limit. Give each model arrays of its own, or all limits at each update.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check daqp==0.11.0 numpy
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import daqp
import numpy as np

# Three thrusters side by side make 2.4 of surge; the first shall work as hard as it may.
n, tau = 3, 2.4
T, sense = np.ones((1, n)), np.array([0] * n + [5], dtype=np.int32)
cost = np.array([-3.0, 0.0, 0.0])


def fill(upper, lower, limit):
    upper[:n], lower[:n] = limit, -limit
    upper[n:] = lower[n:] = tau


def solve(is_reused):
    """Thrusts before the caller's arrays change, after that, and after an update of the cost alone."""
    upper, lower = np.zeros(n + 1), np.zeros(n + 1)
    fill(upper, lower, 1.0)
    model = daqp.Model()
    model.setup(np.eye(n), np.zeros(n), T, upper, lower, sense)
    answers = [model.solve()]
    if is_reused:
        fill(upper, lower, 50.0)  # another vehicle's limits
    answers.append(model.solve())
    model.update(f=cost)
    answers.append(model.solve())
    assert [flag for _, _, flag, _ in answers] == [1, 1, 1]
    return [x for x, *_ in answers]


kept, reused = solve(False), solve(True)
print(f"daqp {version('daqp')}: arrays left alone {kept}, filled anew {reused}")
assert np.abs(kept[2]).max() < 1.0 + 1e-9
assert np.allclose(reused[0], kept[0]) and np.allclose(reused[1], kept[1])
assert reused[2][0] > 2.5
PYTHON
