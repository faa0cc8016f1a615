"""OSQP: solved, 0.01 N outside the attainable set.

What it prints, and how it ends::

    solved [ 250.00285805  250.00285805 -250.00285805 -250.00285805]
    exit code 0
"""

import numpy as np
import osqp
from scipy.sparse import csc_matrix, eye, vstack

c, s = np.cos(np.radians(29)), np.sin(np.radians(29))
T = np.array([[c, c, -c, -c], [s, -s, s, -s], [0.332, -0.332, -0.332, 0.332]])
tau = np.array([4 * 250 * c + 0.01, 0, 0])
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
