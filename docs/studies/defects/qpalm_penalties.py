"""QPALM: answers that depend on earlier calls, without a warm start.

What it prints, and how it ends::

    answers are those of a new object: False
    exit code 0
"""

import numpy as np
import qpalm
from scipy.sparse import csc_matrix

A = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
data = qpalm.Data(4, 7)
data.Q, data.q, data.A = csc_matrix(np.eye(4)), np.zeros(4), csc_matrix(np.vstack([A, np.eye(4)]))
data.bmin, data.bmax = -np.ones(7), np.ones(7)
settings = qpalm.Settings()
settings.verbose = False


def answer(model, b):
    model.update_bounds(np.r_[b, -np.ones(4)], np.r_[b, np.ones(4)])
    model.solve(asynchronous=False)
    return np.array(model.solution.x)


rng, reused, differ = np.random.default_rng(1), qpalm.Solver(data, settings), 0
for side in np.tile([1] * 5 + [-1] * 5, 100):  # five beyond the edge of what |x| <= 1 can give, five inside
    x = rng.uniform(-1, 1, 4)
    b = (1 + side * 10 ** rng.uniform(-5, -0.3)) * 2 / np.ptp(x) * A @ x
    differ += not np.array_equal(answer(reused, b), answer(qpalm.Solver(data, settings), b), equal_nan=True)
print("answers are those of a new object:", differ == 0)
