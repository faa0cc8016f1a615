"""PIQP: infeasible only from afar.

What it prints, and how it ends::

    0.9 1.01 PIQP_MAX_ITER_REACHED 250
    0.9 1.5 PIQP_MAX_ITER_REACHED 250
    0.9 2.0 PIQP_MAX_ITER_REACHED 250
    0.9 3.0 PIQP_PRIMAL_INFEASIBLE 8
    0.001 1.01 PIQP_PRIMAL_INFEASIBLE 9
    0.001 1.5 PIQP_PRIMAL_INFEASIBLE 8
    0.001 2.0 PIQP_PRIMAL_INFEASIBLE 8
    0.001 3.0 PIQP_PRIMAL_INFEASIBLE 8
    exit code 0
"""

import numpy as np
import piqp

for threshold in (0.9, 1e-3):
    for share in (1.01, 1.5, 2.0, 3.0):
        model = piqp.DenseSolver()
        model.settings.infeasibility_threshold = threshold
        model.setup(
            np.eye(2), np.zeros(2), np.ones((1, 2)), np.array([2 * share]), x_l=-np.ones(2), x_u=np.ones(2)
        )
        print(threshold, share, model.solve().name, model.result.info.iter)
