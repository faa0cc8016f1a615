"""PIQP: an answer that changes afterwards.

What it prints, and how it ends::

    [0.5 0.5]
    [-0.5 -0.5]
    exit code 0
"""

import numpy as np
import piqp

model = piqp.DenseSolver()
model.setup(np.eye(2), np.zeros(2), np.ones((1, 2)), np.array([1.0]), x_l=-np.ones(2), x_u=np.ones(2))
model.solve()
first = model.result.x
print(first)
model.update(b=np.array([-1.0]))
model.solve()
print(first)
