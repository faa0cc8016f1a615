"""HiGHS: the time limit holds for all runs of an object together.

What it prints, and how it ends::

    Running HiGHS 1.16.0 (git hash: f3f113d): Copyright (c) 2026 under MIT licence terms
    Includes third-party software components, see THIRD_PARTY_NOTICES.md for full details
    later than the first run: True HighsModelStatus.kTimeLimit
    exit code 0
"""

import highspy
import numpy as np

model = highspy.Highs()
model.setOptionValue("output_flag", False)
model.setOptionValue("time_limit", 0.05)
model.addVar(-1.0, 1.0)
model.addRow(0.5, 0.5, 1, np.array([0]), np.array([1.0]))
model.passHessian(1, 1, 1, np.array([0, 1]), np.array([0]), np.array([1.0]))
for i in range(5000):
    model.clearSolver()
    model.run()
    if model.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        break
print("later than the first run:", i > 0, model.getModelStatus())
