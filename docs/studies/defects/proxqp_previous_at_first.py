"""ProxQP: the previous result as first guess, before there is one.

What it prints, and how it ends::

    SIGSEGV
"""

import numpy as np
from proxsuite import proxqp

A = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
model = proxqp.dense.QP(4, 3, 4)
model.settings.initial_guess = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
model.init(np.eye(4), np.zeros(4), A, np.zeros(3), np.eye(4), -np.ones(4), np.ones(4))
model.update(b=A @ [0.1, 0.2, 0.3, 0.4])
model.solve()
print(model.results.info.status)
