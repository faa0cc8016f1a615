"""HiGHS: a solve error on a strictly convex, feasible problem.

What it prints, and how it ends::

    Running HiGHS 1.16.0 (git hash: f3f113d): Copyright (c) 2026 under MIT licence terms
    Includes third-party software components, see THIRD_PARTY_NOTICES.md for full details
    HighsModelStatus.kSolveError
    exit code 0
"""

import highspy
import numpy as np

A = (
    np.array(
        [
            [-1, 1, 1, -1, 0, 0, 0, 0],
            [0, 0, 0, 0, -1, 1, -1, 1],
            [0, 0, 0, 0, -1, -1, 1, 1],
            [0, 0, 0, 0, -1, -1, -1, -1],
            [-1, -1, 1, 1, 0, 0, 0, 0],
            [1, -1, 1, -1, 0, 0, 0, 0],
        ]
    )
    / 2
)
b = np.array([0.696198, -1.06431, 0.064283, -0.462171, 0.399344, -0.344084])
model = highspy.Highs()
model.setOptionValue("output_flag", False)
for _ in range(8):
    model.addVar(-2 / 3, 1.0)
for row, value in zip(A, b, strict=True):
    model.addRow(value, value, 8, np.arange(8), row)
model.passHessian(8, 8, 1, np.arange(9), np.arange(8), np.ones(8))
model.run()
print(model.getModelStatus())
