"""SuperADMM: operator splitting with a step size for each constraint, in C; dense here."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import TwoSided
from alloc.solvers import TIME_LIMIT_S, Answer, Level, Solve, Start, meaning

REQUIRES, PACKAGE = "superADMM", "superadmm"
VERSION = "0.7.2"
ALGORITHM = "operator splitting (ADMM), a step size a constraint"
LICENCE = "LGPL-2.1-or-later"
STARTS: tuple[Start, ...] = ("cold", "warm")  # superADMM is a function, which keeps nothing

_QUIET = {"verbose": 0, "maxIter": 500, "timeLimit": TIME_LIMIT_S}  # its default cap, written down
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    "tight": _QUIET | {"eps_abs": 1e-10, "eps_rel": 1e-10},
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 1e-5, "tight": 1e-6},
    "soft": {"default": 1e-5, "tight": 1e-6},
}

STATUS = {
    1: Status.SOLVED,
    2: Status.NOT_CONVERGED,  # the tolerance can't be reached
    0: Status.NOT_CONVERGED,  # iteration cap
    -1: Status.NOT_CONVERGED,  # a factorisation failed
    -2: Status.INFEASIBLE,  # or unbounded, which a positive definite H is not
    -3: Status.NOT_CONVERGED,  # time cap
    -4: Status.NOT_CONVERGED,  # not convex: impossible too
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Bounds become rows: low <= [A; I] x <= high, with the rows of I that bound something."""
    from superADMM import superADMM

    sides = TwoSided(qp)
    P, A = np.asfortranarray(qp.H), np.asfortranarray(np.vstack([qp.A, qp.two_sided]))
    options = SETTINGS[level]
    guess: tuple[FloatArray | None, FloatArray | None] = None, None

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        nonlocal guess
        sides.put(b, lb, ub)
        x, y, flag, info = superADMM(P, qp.g, A, sides.low, sides.high, *guess, options)
        status = meaning(STATUS, flag, "superadmm")
        if start == "warm" and status is Status.SOLVED:
            guess = x, y
        return Answer(x, status, info["nIter"], info["runtime"])

    return solve
