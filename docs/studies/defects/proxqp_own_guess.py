"""ProxQP: a guess of one's own.

What it prints, and how it ends::

    {'PROXQP_PRIMAL_INFEASIBLE': 14, 'PROXQP_SOLVED': 986}
    exit code 0
"""

import numpy as np
from proxsuite import proxqp

A = np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
model = proxqp.dense.QP(4, 3, 4)
model.init(np.eye(4), np.zeros(4), A, np.zeros(3), np.eye(4), -np.ones(4), np.ones(4))
model.settings.initial_guess = proxqp.InitialGuess.WARM_START
guess, rng, statuses = (np.zeros(4), np.zeros(3), np.zeros(4)), np.random.default_rng(1), []
for _ in range(1000):
    x = rng.uniform(-1, 1, 4)
    model.update(b=0.99 * 2 / np.ptp(x) * A @ x)  # 1 % inside the edge
    model.solve(*guess)
    statuses.append(model.results.info.status.name)
    if statuses[-1] == "PROXQP_SOLVED":
        guess = tuple(np.array(v) for v in (model.results.x, model.results.y, model.results.z))
print({status: statuses.count(status) for status in sorted(set(statuses))})
