"""ProxQP: the previous result as first guess, later.

What it prints, and how it ends::

    {'PROXQP_PRIMAL_INFEASIBLE': 44, 'PROXQP_SOLVED': 956}
    exit code 0
"""

import numpy as np
from proxsuite import proxqp

A = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
model = proxqp.dense.QP(4, 3, 4)
model.init(np.eye(4), np.zeros(4), A, np.zeros(3), np.eye(4), -np.ones(4), np.ones(4))
model.solve()
model.settings.initial_guess = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
statuses = []
for x in np.random.default_rng(1).uniform(-1, 1, (1000, 4)):
    model.update(b=A @ x)  # x itself is feasible
    model.solve()
    statuses.append(model.results.info.status.name)
print({status: statuses.count(status) for status in sorted(set(statuses))})
