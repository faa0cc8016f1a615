"""PIQP: proximal interior point, dense, in C++."""

from functools import partial
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "piqp"
VERSION = "0.7.0"
ALGORITHM = "proximal interior point"
LICENCE = "BSD-2-Clause"
STARTS: tuple[Start, ...] = ("cold", "reused")  # PIQP takes no first guess

_CAPPED = {"compute_timings": True, "max_iter": 250}  # PIQP's default, written down; it has no time cap
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _CAPPED,
    # A gap of g leaves x up to sqrt(2 g) from the optimum: 1e-6 needs 1e-12. The relative tolerances are
    # what rounding leaves of a soft problem's costs in the thousands.
    "tight": _CAPPED
    | {
        "eps_abs": 1e-11,
        "eps_rel": 1e-11,
        "eps_duality_gap_abs": 1e-13,
        "eps_duality_gap_rel": 1e-15,
        # PIQP scales its data in place, and back before each update: rounding adds up from call to call, and
        # now and then decides the status. A problem that is posed here is scaled already.
        "preconditioner_iter": 0,
    },
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 2e-4, "tight": 1e-6},
    "soft": {"default": 1e-3, "tight": 1e-6},
}

SHARED = 0.0  # with smaller units it fails four times as often where weights are 1e6 apart

STATUS = {
    1: Status.SOLVED,
    -1: Status.NOT_CONVERGED,  # iteration cap
    -2: Status.INFEASIBLE,
    -3: Status.NOT_CONVERGED,  # dual infeasible: impossible with a positive definite H
    -8: Status.NOT_CONVERGED,  # numerics
    -9: Status.NOT_CONVERGED,  # unsolved
    -10: Status.NOT_CONVERGED,  # settings refused
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """The standard form is PIQP's own; only b, x_l and x_u are updated."""
    import piqp

    H, A = np.asfortranarray(qp.H), np.asfortranarray(qp.A)
    sides = {} if qp.sides is None else {"G": np.asfortranarray(qp.sides[0]), "h_u": qp.sides[1]}

    bounded = qp.bounded
    low, high = qp.lb.copy(), qp.ub.copy()
    held = qp.lb[bounded], qp.ub[bounded]

    def set_up(b: FloatArray) -> Any:
        model = piqp.DenseSolver()
        for key, value in SETTINGS[level].items():
            setattr(model.settings, key, value)
        model.setup(H, qp.g, A, b, x_l=low, x_u=high, **sides)
        return model

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        low[bounded], high[bounded] = lb, ub
        return _solve(set_up(b))

    def reused(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        nonlocal held
        if lb is held[0] and ub is held[1]:
            model.update(b=b)
        else:
            low[bounded], high[bounded] = held = lb, ub
            model.update(b=b, x_l=low, x_u=high)
        return _solve(model)

    return cold if start == "cold" else partial(reused, set_up(np.zeros(len(A))))


def _solve(model: Any) -> Answer:
    status = meaning(STATUS, model.solve().value, "piqp")
    result = model.result
    return Answer(result.x.copy(), status, result.info.iter, result.info.run_time)
