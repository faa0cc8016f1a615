"""OSQP: 2 · 10⁹ N, infeasible.

What it prints, and how it ends::

    primal infeasible [2.14328934e+09 2.14328934e+09 2.14328934e+09 2.14328934e+09]
    exit code 0
"""

import numpy as np
import osqp
from scipy.sparse import csc_matrix, eye, vstack

c, s = np.cos(np.radians(29)), np.sin(np.radians(29))
T = np.array([[c, c, -c, -c], [s, -s, s, -s], [0.332, -0.332, -0.332, 0.332]])
tau = np.array([2000.0, 0, 0])
model = osqp.OSQP()
low, high = np.r_[tau, np.full(4, -250.0)], np.r_[tau, np.full(4, 250.0)]
model.setup(
    csc_matrix(np.eye(4)),
    np.zeros(4),
    vstack([csc_matrix(T), eye(4)], format="csc"),
    low,
    high,
    verbose=False,
)
result = model.solve(raise_error=False)
print(result.info.status, result.x)
