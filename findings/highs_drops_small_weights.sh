#!/usr/bin/env bash
# HiGHS drops weights of 1e-9 and less from a QP and calls thrusts optimal at up to 76 times the least effort.
#
# Guess: min sum (f / limit)^2 has the same answer in newtons as in fractions of the largest limit; only T's entries
#   fall under the option small_matrix_value.
# Seen (highspy 1.16.0): for limits of 200 and 799 kN the weights in newtons are below 1e-9, the option's default, and
#   are taken for zero: what is left is a linear program without a cost. Each of 20 demands is Optimal, at 1.6 to 76
#   times the least effort. passModel's kWarning, or a line of its log, is the only sign.
# Consequence: through a wrapper that silences HiGHS the answer is any feasible one, with the best of statuses. Give
#   thrusts as fractions of the largest limit, or multiply the cost.
# Source of T, limits: MSS supply vessel (Fossen), two main propellers and four tunnels.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check highspy==1.16.0 numpy
"$folder/env/bin/python" - <<'PYTHON'
from importlib.metadata import version

import highspy
import numpy as np

T = np.array([[0, 0, 0, 0, 1, 1], [1, 1, 1, 1, 0, 0], [30, 22, -22, -30, -8, 8]], dtype=float)
limit = np.array([200000.0] * 4 + [798720.0] * 2)
k, n = T.shape
rng = np.random.default_rng(0)
demands = [T @ (rng.uniform(-0.9, 0.9, n) * limit) for _ in range(20)]


def solve(tau, unit):
    """Effort in fractions of the limits, status, and what passModel returned, with thrusts in ``unit`` newtons."""
    highs, high = highspy.Highs(), limit / unit
    highs.setOptionValue("output_flag", False)
    model = highspy.HighsModel()
    lp, hessian = model.lp_, model.hessian_
    lp.num_col_, lp.num_row_ = n, k
    lp.col_cost_, lp.col_lower_, lp.col_upper_ = np.zeros(n), -high, high
    lp.row_lower_ = lp.row_upper_ = tau / unit
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_ = np.arange(n + 1) * k, np.tile(np.arange(k), n)
    lp.a_matrix_.value_ = T.T.ravel()
    hessian.dim_, hessian.format_ = n, highspy.HessianFormat.kTriangular
    hessian.start_, hessian.index_, hessian.value_ = np.arange(n + 1), np.arange(n), 1.0 / high**2
    passed = highs.passModel(model)
    highs.run()
    f = np.array(highs.getSolution().col_value) / high
    assert np.abs(f).max() < 1.0 + 1e-9 and np.abs(T @ (f * limit) - tau).max() < 1e-6 * np.abs(tau).max()
    return float(f @ f), highs.modelStatusToString(highs.getModelStatus()), passed


newtons, fractions = ([solve(tau, unit) for tau in demands] for unit in (1.0, limit.max()))
ratios = [found[0] / least[0] for found, least in zip(newtons, fractions, strict=True)]
print(f"highspy {version('highspy')}: effort in newtons by the least: {min(ratios):.2f} to {max(ratios):.1f}")
assert {status for _, status, _ in newtons + fractions} == {"Optimal"}
assert {passed for *_, passed in newtons} == {highspy.HighsStatus.kWarning}
assert {passed for *_, passed in fractions} == {highspy.HighsStatus.kOk}
assert min(ratios) > 1.0 - 1e-9 and max(ratios) > 20.0
PYTHON
