#!/usr/bin/env bash
# How PIQP answers a demand beyond reach changed between two versions, by its count of iterations.
#
# Guess: an interior-point method that proves infeasibility does so in every version, in some ten iterations.
# Seen (piqp 0.6.4, 0.7.0): the former runs to its cap of 250 iterations; the latter proves infeasibility within 20.
# Consequence: a worst-case time measured with one of them is wrong for the other by a factor of ten and more.
# Source of T: four horizontal thrusters of a small ROV, angles and arms rounded.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
for version in 0.6.4 0.7.0; do
  python3 -m venv "$folder/$version"
  "$folder/$version/bin/pip" install --quiet --disable-pip-version-check "piqp==$version" numpy scipy
  "$folder/$version/bin/python" - "$version" <<'PYTHON'
import sys

import numpy as np
import piqp

T = np.array([[0.87, 0.87, -0.87, -0.87], [0.48, -0.48, 0.48, -0.48], [0.33, -0.33, -0.33, 0.33]])
limit, tau = np.ones(4), np.array([2.0, 1.0, 0.8])
solver = piqp.DenseSolver()
solver.setup(np.eye(4), np.zeros(4), T, tau, None, None, None, -limit, limit)
status = str(solver.solve()).rpartition(".")[2]
iterations = solver.result.info.iter
print(f"piqp {sys.argv[1]}: {status} after {iterations} iterations")
if sys.argv[1] == "0.6.4":
    assert status == "PIQP_MAX_ITER_REACHED" and iterations == 250
else:
    assert status == "PIQP_PRIMAL_INFEASIBLE" and iterations < 20
PYTHON
done
