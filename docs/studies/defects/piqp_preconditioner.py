"""PIQP: a preconditioner that rounds the data at each update.

What it prints, and how it ends::

    preconditioner_iter = 10: one problem has one answer: False
    preconditioner_iter = 0: one problem has one answer: True
    exit code 0
"""

import numpy as np
import piqp

rng, b = np.random.default_rng(1), np.ones(2) / 9
P, A = np.diag(rng.uniform(1, 9, 4)), rng.standard_normal((2, 4))
for steps in (10, 0):
    model = piqp.DenseSolver()
    model.settings.preconditioner_iter = steps  # 10 is its default
    model.setup(P, np.zeros(4), A, b, x_l=-np.ones(4), x_u=np.ones(4))
    answers = set()
    for _ in range(1000):
        model.update(b=b)
        model.solve()
        answers.add(model.result.x.tobytes())
    print(f"preconditioner_iter = {steps}: one problem has one answer:", len(answers) == 1)
