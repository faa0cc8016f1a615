#!/usr/bin/env bash
# ElastiQP says Solved where limits are broken by 15 % of their range, as its penalty is less than a multiplier.
#
# Guess: with a penalty of 1e4 ("large") elastic limits are kept wherever all of them can be.
# Seen (elastiqp 0.2.0): an l1 penalty is exact above the largest multiplier only, and multipliers of min f'f/2
#   are as large as the thrusts. In newtons, for a supply vessel, a demand that can be met is Solved, converged,
#   with thrusts outside their limits. Divided by the largest limit the same demand is met within them.
# Consequence: give it thrusts as fractions of the largest limit, or a penalty above the thrust in its unit.
# Source of T, limits: MSS supply vessel (Fossen), two main propellers and four tunnels.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check elastiqp==0.2.0 numpy
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import elastiqp
import numpy as np

T = np.array([[0, 0, 0, 0, 1, 1], [1, 1, 1, 1, 0, 0], [30, 22, -22, -30, -8, 8]], dtype=float)
limit = np.array([200000.0] * 4 + [798720.0] * 2)
tau = np.array([-1045659.4, -419576.7, -15016604.2])
G = np.vstack([np.eye(6), -np.eye(6)])
outside = {}
for unit in (1.0, limit.max()):
    h = np.tile(limit / unit, 2)
    found = elastiqp.solve(np.eye(6), np.zeros(6), G, h, 1e4, A=T, b=tau / unit)
    outside[unit] = float(((np.abs(found.x) - limit / unit) / (2 * limit / unit)).max())
    missed = np.abs(T @ found.x - tau / unit).max() / np.abs(tau / unit).max()
    print(f"elastiqp {version('elastiqp')}, unit {unit:g} N: {found.status}, outside by {outside[unit]:.4f} of a range")
    assert found.status == elastiqp.Status.Solved and missed < 1e-9
assert outside[1.0] > 0.1
assert outside[limit.max()] < 1e-6
PYTHON
