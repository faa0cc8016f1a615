"""CVXOPT: infeasible is unknown.

What it prints, and how it ends::

    exit code 1: ValueError: domain error
"""

import numpy as np
from cvxopt import matrix, solvers

eye = np.eye(2)
G, h, A = matrix(np.vstack([eye, -eye])), matrix(np.ones(4)), matrix(np.ones((1, 2)))
solvers.coneqp(
    matrix(eye), matrix(np.zeros(2)), G, h, None, A, matrix(np.array([4.0])), options={"show_progress": False}
)
