"""ECOS: a stall before a gap of 1e-11.

What it prints, and how it ends::

    {1e-08: 0, 1e-11: 108} of 5000 problems, by gap, end close to optimal
    exit code 0
"""

from collections import Counter

import ecos
import numpy as np
from scipy.sparse import csc_matrix

A = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
cone = np.block([[np.zeros((1, 4)), -np.ones((1, 1))], [-np.eye(4), np.zeros((4, 1))]])  # |x| <= t, the least
G = csc_matrix(np.vstack([np.eye(4, 5), -np.eye(4, 5), cone]))
h, c, rows = np.r_[np.ones(8), np.zeros(5)], np.eye(5)[4], csc_matrix(np.column_stack([A, np.zeros(3)]))
rng, found = np.random.default_rng(1), Counter()
for _ in range(5000):
    b = A @ rng.uniform(-1, 1, 4)
    for gap in (1e-8, 1e-11):
        answer = ecos.solve(c, G, h, {"l": 8, "q": [5]}, rows, b, verbose=False, abstol=gap, reltol=gap)
        found[gap] += answer["info"]["infostring"] == "Close to optimal solution found"
print(dict(found), "of 5000 problems, by gap, end close to optimal")
