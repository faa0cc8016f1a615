"""SIP: a variable whose bounds are equal.

What it prints, and how it ends::

    1.0 SOLVED [0.5 0.5]
    1e-06 ITERATION_LIMIT [0.5 0.5]
    0.0 FAILED_CHECK [0. 0.]
    exit code 0
"""

import numpy as np
import sip_qp_python as sip
from scipy.sparse import csc_matrix, csr_matrix

P, none, A = csc_matrix(np.eye(2)), csr_matrix((0, 2)), csr_matrix(np.ones((1, 2)))
settings = sip.Settings()
for width in (1.0, 1e-6, 0.0):
    low, high = np.array([0.5, -1.0]), np.array([0.5 + width, 1.0])
    model = sip.Solver(
        P,
        np.zeros(2),
        none,
        np.zeros(0),
        A,
        np.ones(1),
        low,
        high,
        np.arange(3, dtype=np.int32),
        settings,
        1.0,
    )
    result = model.solve(np.zeros(2))
    print(width, result.info.exit_status.name, np.round(result.x, 3))
