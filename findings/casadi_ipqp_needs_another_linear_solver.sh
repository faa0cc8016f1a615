#!/usr/bin/env bash
# CasADi's own interior point solver solves no QP with an equality by its default linear solver.
#
# Guess: conic("...", "ipqp", ...) solves T f = tau within limits by its defaults, as the other plug-ins do.
# Seen (casadi 3.8.2): each of 12 attainable demands ends with "Maximum number of iterations reached" and NaN. With
#   tau as a band of 0.001 N all are solved; with linear_solver set to qr all are solved with the equality too.
# Consequence: the plug-in that needs no foreign library looks useless for allocation; one option mends it.
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check casadi==3.8.2
"$folder/env/bin/python" - <<'PYTHON'
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
quiet = {"error_on_fail": False, "print_iter": False, "print_header": False, "print_info": False}


def solved(options, band):
    solver = casadi.conic("allocate", "ipqp", shapes, {**quiet, **options})
    rng, count, words = np.random.default_rng(1), 0, set()
    for _ in range(12):
        tau = T @ rng.uniform(-40.0, 40.0, n)
        limits = {"lba": tau - band, "uba": tau + band, "lbx": np.full(n, -40.0), "ubx": np.full(n, 40.0)}
        f = np.array(solver(h=np.eye(n), g=np.zeros(n), a=T, **limits)["x"]).ravel()
        words.add(solver.stats()["return_status"])
        count += bool(np.abs(T @ f - tau).max() < band + 1e-6 and np.abs(f).max() < 40.0 + 1e-6)
    return count, words


ldl, wide, qr = solved({}, 0.0), solved({}, 1e-3), solved({"linear_solver": "qr"}, 0.0)
print(f"casadi {version('casadi')}: of 12 solved with ldl {ldl}, with a band {wide}, with qr {qr}")
assert ldl == (0, {"Maximum number of iterations reached"})
assert wide[0] == qr[0] == 12
PYTHON
