#!/usr/bin/env bash
# HiGHS takes a start for a QP, says kOk, and does not use it.
#
# Guess: setSolution with the optimum of the same QP saves iterations, as it does for an LP or a MIP.
# Seen (highspy 1.16.0): the call returns kOk, and the QP takes as many iterations as without; also with the
#   option qp_allow_hot_start, which is off by default and which the options object of Python does not show.
# Consequence: a "warm" row of HiGHS' QP by setSolution is its cold row once more.
# Source of T: six thrusters in a plane, made up for this script.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check highspy==1.16.0 numpy
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import highspy
import numpy as np

T = np.array(
    [
        [0.707, -0.707, -0.707, 0.707, 1.0, 0.0],
        [0.707, 0.707, -0.707, -0.707, 0.0, 1.0],
        [0.071, 0.071, 0.495, 0.495, -0.25, 0.2],
    ]
)
tau = np.array([-2.247, -0.114, 1.154])
k, n = T.shape


def solve(start, hot=False):
    highs = highspy.Highs()
    highs.setOptionValue("output_flag", False)
    assert highs.setOptionValue("qp_allow_hot_start", hot) == highspy.HighsStatus.kOk
    model = highspy.HighsModel()
    lp, hessian = model.lp_, model.hessian_
    lp.num_col_, lp.num_row_ = n, k
    lp.col_cost_, lp.col_lower_, lp.col_upper_ = np.zeros(n), -np.ones(n), np.ones(n)
    lp.row_lower_ = lp.row_upper_ = tau
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_ = np.arange(n + 1) * k, np.tile(np.arange(k), n)
    lp.a_matrix_.value_ = T.T.ravel()
    hessian.dim_, hessian.format_ = n, highspy.HessianFormat.kTriangular
    hessian.start_, hessian.index_, hessian.value_ = np.arange(n + 1), np.arange(n), np.ones(n)
    highs.passModel(model)
    taken = None
    if start is not None:
        solution = highspy.HighsSolution()
        solution.col_value = list(start)
        taken = highs.setSolution(solution)
    highs.run()
    status = highs.modelStatusToString(highs.getModelStatus())
    return np.array(highs.getSolution().col_value), highs.getInfo().qp_iteration_count, status, taken


f, cold, status, _ = solve(None)
warm = {hot: solve(f, hot) for hot in (False, True)}
counts = {hot: found[1] for hot, found in warm.items()}
print(f"highspy {version('highspy')}: {cold} iterations; from the optimum, by qp_allow_hot_start: {counts}")
for again, iterations, status_again, taken in warm.values():
    assert status == status_again == "Optimal" and np.abs(again - f).max() < 1e-9
    assert taken == highspy.HighsStatus.kOk
    assert iterations == cold > 0
PYTHON
