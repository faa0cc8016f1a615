"""quadprog: inconsistent, at vertices of what |x| <= 1 can give.

What it prints, and how it ends::

    60 of 1000 vertices: constraints are inconsistent, no solution
    exit code 0
"""

import numpy as np
import quadprog

rng, refused = np.random.default_rng(1), 0
for _ in range(1000):
    A = rng.standard_normal((3, 5))
    vertex = A @ np.sign(A.T @ rng.standard_normal(3))
    rows, sides = np.vstack([A, np.eye(5), -np.eye(5)]), np.r_[vertex, -np.ones(10)]
    try:
        quadprog.solve_qp(np.eye(5), np.zeros(5), rows.T, sides, 3)
    except ValueError as error:
        refused, said = refused + 1, error
print(refused, "of 1000 vertices:", said)
