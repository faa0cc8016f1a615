#!/usr/bin/env bash
# CasADi's plug-in for Fatrop returns the right thrusts with a cost of zero.
#
# Guess: conic("...", "fatrop", ...) returns x'Hx/2 + g'x in "cost", as the other plug-ins do.
# Seen (casadi 3.8.2): success, the same thrusts and multipliers as qrqp's, and cost 0 for each demand.
# Consequence: a comparison by cost makes Fatrop the best of all solvers, at less than the least effort. Compute the
#   cost from x.
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check casadi==3.8.2
"$folder/env/bin/python" - > "$folder/shown" <<'PYTHON'
from importlib.metadata import version

import casadi
import numpy as np

T = np.array(
    [
        [0.707, -0.707, -0.707, 0.707, 1.0, 0.0],
        [0.707, 0.707, -0.707, -0.707, 0.0, 1.0],
        [0.071, 0.071, 0.495, 0.495, -0.25, 0.2],
    ]
)
k, n = T.shape
shapes = {"h": casadi.DM(np.eye(n)).sparsity(), "a": casadi.DM(T).sparsity()}
quiet = {"print_iter": False, "print_header": False, "print_info": False}
solvers = {name: casadi.conic("allocate", name, shapes, quiet if name == "qrqp" else {}) for name in ("qrqp", "fatrop")}
rng, costs = np.random.default_rng(1), {name: [] for name in solvers}
for _ in range(5):
    tau, thrusts = T @ rng.uniform(-0.9, 0.9, n), []
    for name, solver in solvers.items():
        found = solver(h=np.eye(n), a=T, lba=tau, uba=tau, lbx=-np.ones(n), ubx=np.ones(n))
        thrusts.append(np.array(found["x"]).ravel())
        assert solver.stats()["success"]
        costs[name].append(float(found["cost"]))
    assert np.abs(thrusts[1] - thrusts[0]).max() < 1e-6
print(f"\ncasadi {version('casadi')}: costs of five demands: {costs}")
assert min(costs["qrqp"]) > 0.05 and costs["fatrop"] == [0.0] * 5
PYTHON
tail -n 1 "$folder/shown"  # Fatrop prints more
