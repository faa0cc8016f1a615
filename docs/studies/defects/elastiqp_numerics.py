"""ElastiQP: "Numerics" from its last answer, where a start afresh mostly solves.

What it prints, and how it ends::

    {True: 63, False: 1} of 20000 problems end in Numerics, by warm_start
    exit code 0
"""

import numpy as np
from elastiqp import das

rng, failed = np.random.default_rng(1), {True: 0, False: 0}
for _ in range(20):
    A = rng.standard_normal((4, 6))
    A /= np.linalg.norm(A, axis=1)[:, None]
    H, G = np.diag(10 ** rng.uniform(-8, 0, 6)), np.asfortranarray(np.vstack([A, -A, np.eye(6), -np.eye(6)]))
    models = {}
    for warm in failed:
        models[warm] = das.Solver()
        models[warm].settings.warm_start = warm
        models[warm].setup(H, np.zeros(6), G, np.ones(20), np.repeat([1e6, 1e12], [8, 12]))
    for _ in range(1000):
        low, high = np.sort(rng.uniform(-1, 1, (2, 6)), axis=0)
        b = rng.choice([1, 3]) * A @ rng.uniform(low, high)
        for warm, model in models.items():
            model.update(h=np.r_[b, -b, high, -low])
            failed[warm] += model.solve().status.name == "Numerics"
print(failed, "of 20000 problems end in Numerics, by warm_start")
