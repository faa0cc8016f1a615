"""ElastiQP: dual active set, in C++; limits may give way at a price, which is set too high for that."""

from collections.abc import Callable
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import OneSided
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "elastiqp"
VERSION = "0.2.0"
ALGORITHM = "dual active set, elastic limits"
LICENCE = "Apache-2.0"
STARTS: tuple[Start, ...] = ("cold", "reused", "warm")

PENALTY = 1e6
"""Price of a limit that gives way [-]. The answer is that of hard limits where no multiplier reaches it, and
multipliers are as large as thrusts times weights, which are of order 1 in the units of the QP. In newtons
they pass 1e4: limits are then broken, and the answer is called solved."""

_CAPPED = {"max_iter": 10_000}  # its default, written down; it has no time cap
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _CAPPED,
    "tight": _CAPPED | {"eps_abs": 1e-10},  # a limit broken by less counts as kept; default 1e-6
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 1e-5, "tight": 3e-9},  # one of 199,760 on random vehicles: 1.04e-9
    "soft": {"default": 1e-5, "tight": 1e-9},
}

STATUS = {
    "Solved": Status.SOLVED,  # INFEASIBLE where a limit gave way
    "Infeasible": Status.INFEASIBLE,  # the equations alone contradict each other
    "MaxIter": Status.NOT_CONVERGED,
    "Numerics": Status.NOT_CONVERGED,
    "Unsolved": Status.NOT_CONVERGED,
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Equations A x = b, finite bounds as G x <= h that cost ``PENALTY`` to break."""
    p = len(qp.A)
    H, A, G = (np.asfortranarray(matrix) for matrix in (qp.H, qp.A, qp.one_sided[0]))
    sides = OneSided(qp)

    def set_up() -> Any:
        model = _model(level, start)
        # A vehicle whose thrusters are stuck or off may have no equation left, and none is then taken.
        model.setup(H, qp.g, G, sides.right[p:], PENALTY, **({"A": A, "b": sides.right[:p]} if p else {}))
        return model

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        return _solve(set_up())

    kept = set_up()

    def reused(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        kept.update(h=sides.right[p:], **({"b": sides.right[:p]} if p else {}))
        return _solve(kept)

    return cold if start == "cold" else reused


def prepare_rows(
    H: FloatArray, G: FloatArray, h: FloatArray, prices: FloatArray, level: Level
) -> Callable[[FloatArray], Answer]:
    """Prepare min 1/2 x'Hx + prices'max(G x - h, 0): each row gives way at its price; only h (r,) changes."""
    model = _model(level, "reused")
    model.setup(np.asfortranarray(H), np.zeros(len(H)), np.asfortranarray(G), h, prices)

    def solve(h: FloatArray) -> Answer:
        model.update(h=h)
        return _answer(model.solve())

    return solve


def _model(level: Level, start: Start) -> Any:
    import elastiqp

    model = elastiqp.das.Solver()
    model.settings.warm_start = start == "warm"  # its default is True
    for key, value in SETTINGS[level].items():
        setattr(model.settings, key, value)
    return model


def _solve(model: Any) -> Answer:
    solution = model.solve()
    answer = _answer(solution)
    gave_way = answer.status is Status.SOLVED and solution.n_saturated
    return answer._replace(status=Status.INFEASIBLE) if gave_way else answer


def _answer(solution: Any) -> Answer:
    status = meaning(STATUS, solution.status.name, "elastiqp")
    return Answer(np.array(solution.x), status, solution.iters)
