"""ProxQP with the previous result as its first guess before there is one: it crashes or hangs.

This is a plug-in for ``thrustbench run --plugin docs/studies/proxqp_previous.py``, where the crash becomes a
row with a reason. ``qp/proxqp`` warm hands over the last point instead (docs/solvers.md).
"""

import numpy as np

from alloc import Status, Vehicle
from alloc.allocation import FloatArray
from alloc.live.allocator import Live
from alloc.qp import pose_hard
from alloc.solvers import Answer

FORMULATION = "hard"
STARTS = ("warm",)


def build(vehicle: Vehicle, start: str = "warm") -> Live:
    """An allocator that ends its process."""
    from proxsuite import proxqp

    posed = pose_hard(vehicle)
    qp, m = posed.qp, len(posed.qp.g)
    model = proxqp.dense.QP(m, len(qp.A), m)
    model.settings.initial_guess = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
    model.init(qp.H, qp.g, qp.A, np.zeros(len(qp.A)), np.eye(m), qp.lb, qp.ub)

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        model.update(b=b, l=lb, u=ub)
        model.solve()
        solved = model.results.info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
        return Answer(model.results.x.copy(), Status.SOLVED if solved else Status.NOT_CONVERGED)

    return Live(FORMULATION, vehicle, posed, solve, 1.0, "proxqp")
