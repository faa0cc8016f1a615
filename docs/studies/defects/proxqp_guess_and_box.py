"""ProxQP: a guess and box constraints.

What it prints, and how it ends::

    SIGSEGV
"""

import numpy as np
from proxsuite import proxqp

model = proxqp.dense.QP(2, 1, 0, True)
model.init(np.eye(2), np.zeros(2), np.ones((1, 2)), np.ones(1), None, None, None, -np.ones(2), np.ones(2))
model.settings.initial_guess = proxqp.InitialGuess.WARM_START
model.solve(np.zeros(2), np.zeros(1), np.zeros(0))
print(model.results.info.status)
