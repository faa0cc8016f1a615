"""DAQP: dual active set, in C; finitely many steps, exact up to rounding."""

from functools import partial
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.errors import NotApplicable
from alloc.qp import QP
from alloc.solvers import TIME_LIMIT_S, Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "daqp"
VERSION = "0.11.0"
ALGORITHM = "dual active set"
LICENCE = "MIT"
STARTS: tuple[Start, ...] = ("cold", "reused", "warm")

_CAPPED = {"iter_limit": 10_000, "time_limit": TIME_LIMIT_S}  # DAQP's default cap, written down
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _CAPPED,
    "tight": _CAPPED | {"primal_tol": 1e-10},  # a limit violated by less counts as kept; default 1e-6
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 1e-5, "tight": 1e-9},
    "soft": {"default": 1e-5, "tight": 1e-9},
}

STATUS = {
    1: Status.SOLVED,
    2: Status.NOT_CONVERGED,  # soft optimal: no constraint here is soft
    -1: Status.INFEASIBLE,
    -2: Status.NOT_CONVERGED,  # cycling
    -3: Status.NOT_CONVERGED,  # unbounded: impossible with a positive definite H
    -4: Status.NOT_CONVERGED,  # iteration cap
    -5: Status.NOT_CONVERGED,  # not convex
    -6: Status.INFEASIBLE,  # the equalities alone contradict each other
    -7: Status.NOT_CONVERGED,  # time cap
    -8: Status.NOT_CONVERGED,  # a problem that it does not take
}
INFINITE, EQUALITY = 1e30, 5  # in DAQP's conventions


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Bounds come first, then the rows of A, marked as equalities, then the sides."""
    import daqp

    p, m = qp.A.shape
    bounded = qp.bounded
    held = qp.lb[bounded], qp.ub[bounded]
    # Thrusts come first among the variables, and writing a slice is quicker than writing by indices.
    place = slice(len(bounded)) if len(bounded) == bounded[-1] + 1 else bounded
    C, d = qp.sides or (np.zeros((0, m)), np.zeros(0))
    H, A, rows = np.ascontiguousarray(qp.H), np.ascontiguousarray(qp.A), slice(m, m + p)
    # Set-up fails where variables with equal bounds contradict the equations: start from equations that hold.
    met = A @ np.clip(0.0, qp.lb, qp.ub)
    low = np.concatenate([np.maximum(qp.lb, -INFINITE), met, np.full(len(d), -INFINITE)])
    high = np.concatenate([np.minimum(qp.ub, INFINITE), met, d])
    sense = np.array([0] * m + [EQUALITY] * p + [0] * len(d), dtype=np.intc)
    left = np.vstack([A, C])

    def set_up() -> tuple[Any, int]:
        model = daqp.Model()
        model.settings = SETTINGS[level]
        flag, _ = model.setup(H, qp.g, left, high, low, sense)
        return model, flag

    def put(b: FloatArray, lb: FloatArray, ub: FloatArray) -> None:
        nonlocal held
        low[rows] = high[rows] = b
        if lb is not held[0] or ub is not held[1]:
            low[place], high[place] = lb, ub
            held = lb, ub

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        put(b, lb, ub)
        model, flag = set_up()
        if flag < 0:  # set-up failed, so there is nothing to solve
            return Answer(qp.g, meaning(STATUS, flag, "daqp"))
        return _solve(model)

    def reused(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        if lb is held[0] and ub is held[1]:
            low[rows] = high[rows] = b
        else:
            put(b, lb, ub)
        model.update(bupper=high, blower=low, sense=sense)  # a `sense` drops the last active set
        return _solve(model)

    def warm(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        put(b, lb, ub)
        if model.update(bupper=high, blower=low) < 0:
            # A failed update stops half-way through the active set and would spoil every later answer.
            model.update(bupper=high, blower=low, sense=sense)
        return _solve(model)

    if start == "cold":
        return cold
    model, flag = set_up()
    if flag < 0:
        raise NotApplicable(
            f"DAQP can't set this problem up, exit flag {flag}: T or H is too close to singular; "
            "use another solver"
        )
    return partial(warm if start == "warm" else reused, model)


def _solve(model: Any) -> Answer:
    x, _, flag, info = model.solve()
    status = meaning(STATUS, flag, "daqp")
    return Answer(x, status, info["iterations"], info["solve_time"])
