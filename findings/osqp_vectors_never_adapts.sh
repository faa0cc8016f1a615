#!/usr/bin/env bash
# C that OSQP generates never adapts its step size by default, whatever adaptive_rho says.
#
# Guess: adaptive_rho=1, given at setup, holds in the C that codegen writes, as it does from Python.
# Seen (osqp 1.1.3): with parameters="vectors", codegen's default, the C leaves adaptation out without a word and
#   needs five times the iterations; with parameters="matrices" it adapts, without a heap either.
# Consequence: time OSQP's C by "matrices", or it is a straw man.
# Source of T, limits: MSS supply vessel (Fossen), two main propellers and four tunnels, in units of 200 kN.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check osqp==1.1.3 numpy scipy setuptools
cd "$folder"
cat > main.c <<'C'
#include <stdio.h>
#include "osqp.h"
#include "workspace.h"
int main(void)
{
    osqp_solve(&solver);
    printf("%s %d\n", solver.info->status, (int)solver.info->iter);
    return 0;
}
C
"$folder/env/bin/python" - <<'PYTHON'
import subprocess
from pathlib import Path

import numpy as np
import osqp
from scipy import sparse

T = np.array([[0, 0, 0, 0, 1, 1], [1, 1, 1, 1, 0, 0], [30, 22, -22, -30, -8, 8]], dtype=float)
limit = np.array([1.0] * 4 + [4.0] * 2)
tau = np.array([-5.2, -2.1, -75.1])
A = sparse.csc_matrix(np.vstack([T, np.eye(6)]))
rest = {"verbose": False, "adaptive_rho": 1, "scaling": 0, "eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 100000}
answers = {}
for parameters in ("vectors", "matrices"):
    solver = osqp.OSQP()
    bounds = np.r_[tau, -limit], np.r_[tau, limit]
    solver.setup(sparse.eye(6, format="csc"), np.zeros(6), A, *bounds, **rest)
    solver.codegen(parameters, parameters=parameters, force_rewrite=True)
    sources = [str(path) for path in Path(parameters).rglob("*.c") if "emosqp" not in path.name]
    sources = [path for path in sources if "example" not in path]
    includes = {f"-I{path.parent}" for path in Path(parameters).rglob("*.h")}
    subprocess.run(["cc", "-O2", "-w", *includes, "main.c", *sources, "-lm", "-o", f"run-{parameters}"], check=True)
    done = subprocess.run([f"./run-{parameters}"], capture_output=True, text=True, check=True)
    status, _, iterations = done.stdout.strip().rpartition(" ")
    answers[parameters] = status, int(iterations)
print("osqp", osqp.__version__, answers)
assert {status for status, _ in answers.values()} == {"solved"}
assert answers["vectors"][1] > 4 * answers["matrices"][1]
PYTHON
