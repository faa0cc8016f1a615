"""QOCO: infeasible is a numerical error.

What it prints, and how it ends::

    QOCO_SOLVED
    QOCO_NUMERICAL_ERROR
    exit code 0
"""

import numpy as np
import qoco
from scipy.sparse import csc_matrix

eye = np.eye(2)
P, A, G = csc_matrix(eye), csc_matrix(np.ones((1, 2))), csc_matrix(np.vstack([eye, -eye]))
for b in (1.0, 3.0):  # at most 2 is within |x| <= 1
    model = qoco.QOCO()
    model.setup(2, 4, 1, P, np.zeros(2), A, np.array([b]), G, np.ones(4), 4, 0, None)
    print(model.solve().status)
