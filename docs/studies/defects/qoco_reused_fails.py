"""QOCO: an object that gave up once fails where a new one solves.

What it prints, and how it ends::

    {'new': 0, 'reused': 42} of 500 feasible problems
    exit code 0
"""

import numpy as np
import qoco
from scipy.sparse import csc_matrix

A = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
P, G, limits = csc_matrix(np.eye(4)), csc_matrix(np.vstack([np.eye(4), -np.eye(4)])), np.ones(8)


def new():
    model = qoco.QOCO()
    model.setup(
        4, 8, 3, P, np.zeros(4), csc_matrix(A), np.zeros(3), G, limits, 8, 0, None, abstol=1e-11, reltol=1e-11
    )
    return model


def fails(model, b):
    model.update_vector_data(b=b)
    return int(model.solve().status != "QOCO_SOLVED")


rng, reused, failed = np.random.default_rng(1), new(), {"new": 0, "reused": 0}
for side in np.tile([1] * 5 + [-1] * 5, 100):  # five beyond the edge of what |x| <= 1 can give, five inside
    x = rng.uniform(-1, 1, 4)
    b = (1 + side * 10 ** rng.uniform(-5, -0.3)) * 2 / np.ptp(x) * A @ x
    wrong = fails(reused, b)
    if side < 0:
        failed["new"] += fails(new(), b)
        failed["reused"] += wrong
print(failed, "of 500 feasible problems")
