"""Clarabel: a clock that counts the set-up again and again.

What it prints, and how it ends::

    True
    True
    True
    exit code 0
"""

import time

import clarabel
import numpy as np
from scipy.sparse import csc_matrix, eye

settings = clarabel.DefaultSettings()
settings.verbose, settings.presolve_enable = False, False
n = 300
model = clarabel.DefaultSolver(
    csc_matrix(np.ones((n, n)) + n * np.eye(n)),
    -np.ones(n),
    eye(n, format="csc"),
    np.ones(n),
    [clarabel.NonnegativeConeT(n)],
    settings,
)
for _ in range(3):
    model.update(b=np.ones(n))
    start = time.perf_counter()
    own = model.solve().solve_time
    print(own > time.perf_counter() - start)
