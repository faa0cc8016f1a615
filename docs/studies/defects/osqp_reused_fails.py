"""OSQP: a reused object fails where a new one solves.

What it prints, and how it ends::

    {'new': 0, 'reused': 16} of 500 feasible problems
    exit code 0
"""

import numpy as np
import osqp
from scipy.sparse import csc_matrix, eye, vstack

A = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
rows = vstack([csc_matrix(A), eye(4)], format="csc")


def new():
    model = osqp.OSQP()
    model.setup(
        csc_matrix(np.eye(4)), np.zeros(4), rows, -np.ones(7), np.ones(7), verbose=False, warm_starting=False
    )
    return model


def fails(model, b):
    model.update(l=np.r_[b, -np.ones(4)], u=np.r_[b, np.ones(4)])
    return int(model.solve(raise_error=False).info.status != "solved")


rng, reused, failed = np.random.default_rng(1), new(), {"new": 0, "reused": 0}
for side in np.tile([1] * 5 + [-1] * 5, 100):  # five beyond the edge of what |x| <= 1 can give, five inside
    x = rng.uniform(-1, 1, 4)
    b = (1 + side * 10 ** rng.uniform(-5, -0.3)) * 2 / np.ptp(x) * A @ x
    wrong = fails(reused, b)
    if side < 0:
        failed["new"] += fails(new(), b)
        failed["reused"] += wrong
print(failed, "of 500 feasible problems")
