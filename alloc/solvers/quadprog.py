"""quadprog: dual active set (Goldfarb and Idnani), in C; finitely many steps, exact up to rounding."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.sides import OneSided
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "quadprog"
ALGORITHM = "dual active set (Goldfarb and Idnani)"
LICENCE = "GPL-2.0-or-later"
STARTS: tuple[Start, ...] = ("cold", "reused")  # solve_qp is a function: the factor of H is reused

SETTINGS: dict[Level, dict[str, Any]] = {"default": {}}  # quadprog has no settings and no caps
TOLERANCE: dict[str, dict[Level, float]] = {"hard": {"default": 1e-9}, "soft": {"default": 1e-9}}

STATUS = {"constraints are inconsistent, no solution": Status.INFEASIBLE}  # quadprog raises, with these words


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Rows C'x >= b, the equalities first; H = R'R is factorised once for the reused start."""
    import quadprog

    p = len(qp.A)
    rows, _ = qp.one_sided
    sides = OneSided(qp)
    C = np.ascontiguousarray(np.vstack([qp.A, -rows]).T)
    sign = np.where(np.arange(p + len(rows)) < p, 1.0, -1.0)
    factorized = start == "reused"
    G = np.linalg.inv(np.linalg.cholesky(qp.H)).T if factorized else qp.H
    G, a = np.ascontiguousarray(G), -qp.g

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        try:
            x, _, _, iterations, _, _ = quadprog.solve_qp(G, a, C, sign * sides.right, p, factorized)
        except ValueError as error:
            return Answer(a, meaning(STATUS, str(error), "quadprog"))
        return Answer(x, Status.SOLVED, int(iterations[0]))

    return solve
