"""SCS: answers that depend on earlier calls, without a warm start.

What it prints, and how it ends::

    46 of 1000 problems have another status than from a new object
    exit code 0
"""

import numpy as np
import scs
from scipy.sparse import csc_matrix

A = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
rows = csc_matrix(np.vstack([A, np.eye(4), -np.eye(4)]))
data = {"P": csc_matrix(np.eye(4)), "A": rows, "b": np.ones(11), "c": np.zeros(4)}


def new():
    return scs.SCS(data, {"z": 3, "l": 8}, verbose=False)


def status(model, b):
    model.update(b=np.r_[b, np.ones(8)])
    return model.solve(warm_start=False)["info"]["status"]


rng, reused, differ = np.random.default_rng(1), new(), 0
for side in np.tile([1] * 5 + [-1] * 5, 100):  # five beyond the edge of what |x| <= 1 can give, five inside
    x = rng.uniform(-1, 1, 4)
    b = (1 + side * 10 ** rng.uniform(-5, -0.3)) * 2 / np.ptp(x) * A @ x
    differ += status(reused, b) != status(new(), b)
print(differ, "of 1000 problems have another status than from a new object")
