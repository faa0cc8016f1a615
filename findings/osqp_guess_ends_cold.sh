#!/usr/bin/env bash
# One warm_start makes an OSQP object that was set up cold warm for good, and its settings still say cold.
#
# Guess: with warm_starting=False a guess given by warm_start() holds for the next solve, and the one after is cold again.
# Seen (osqp 1.1.3): from that call on each solve starts at the answer before, with the same iterations as an object set
#   up with warm_starting=True. settings.warm_starting is 0 before and after. update_settings(warm_starting=False) mends it.
# Consequence: a benchmark that gives one guess, then times "cold" calls, times warm ones, whose answers depend on their
#   order. Switch warm starts off again after each guess.
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check osqp==1.1.3
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import numpy as np
import osqp
from scipy import sparse

T = np.array(
    [
        [0.707, -0.707, -0.707, 0.707, 1.0, 0.0],
        [0.707, 0.707, -0.707, -0.707, 0.0, 1.0],
        [0.071, 0.071, 0.495, 0.495, -0.25, 0.2],
    ]
)
k, n = T.shape
rows, limit = sparse.csc_matrix(np.vstack([T, np.eye(n)])), np.ones(n)
rng = np.random.default_rng(0)
demands = [T @ rng.uniform(-0.9, 0.9, n) for _ in range(8)]


def iterations(warm_starting, guess=False, off_again=False):
    """Iterations of each demand by one object, and what its settings say of warm starts at the end."""
    solver = osqp.OSQP()
    options = {"verbose": False, "warm_starting": warm_starting, "check_termination": 1, "adaptive_rho": 0}
    solver.setup(sparse.eye(n, format="csc"), np.zeros(n), rows, -np.ones(k + n), np.ones(k + n), **options)
    if guess:
        solver.warm_start(x=np.zeros(n))
    if off_again:
        solver.update_settings(warm_starting=False)
    counts = []
    for tau in demands:
        solver.update(l=np.r_[tau, -limit], u=np.r_[tau, limit])
        counts.append(solver.solve().info.iter)
    return counts, solver.settings.warm_starting


cold, warm = iterations(False), iterations(True)
guess, off = iterations(False, guess=True), iterations(False, guess=True, off_again=True)
print(f"osqp {version('osqp')}: cold {cold}, warm {warm}, one guess {guess}, switched off again {off}")
assert cold[0] != warm[0] and cold[1] == 0
assert guess == (warm[0], 0)
assert off == cold
PYTHON
