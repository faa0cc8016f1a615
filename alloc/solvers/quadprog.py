"""quadprog: dual active set (Goldfarb and Idnani), in C; finitely many steps, exact up to rounding."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import OneSided, whitened
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "quadprog"
VERSION = "0.1.14"
ALGORITHM = "dual active set (Goldfarb and Idnani)"
LICENCE = "GPL-2.0-or-later"
STARTS: tuple[Start, ...] = ("cold", "reused")  # solve_qp is a function: the factor of H is reused

SETTINGS: dict[Level, dict[str, Any]] = {"default": {}}  # quadprog has no settings and no caps
TOLERANCE: dict[str, dict[Level, float]] = {"hard": {"default": 1e-9}, "soft": {"default": 1e-9}}

STATUS = {"constraints are inconsistent, no solution": Status.INFEASIBLE}  # quadprog raises, with these words


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Rows C'x >= b, the equalities first; H = R'R is factorised once for the reused start.

    A full H is made the identity, which leaves quadprog a third of its failures where weights are far apart.
    """
    import quadprog

    p = len(qp.A)
    rows, _ = qp.one_sided
    sides, white = OneSided(qp), whitened(qp)
    factorized = start == "reused"
    G, a, A, back, length = qp.H, -qp.g, qp.A, None, np.ones(len(rows))
    if white is not None:
        G, a, A, back = np.eye(len(qp.g)), -white.g, white.A, white.back
        length = np.linalg.norm(rows @ back, axis=1)
        rows = rows @ back / length[:, None]
    turn = None if white is None else white.turn
    if factorized:
        G = np.linalg.inv(np.linalg.cholesky(G)).T
    G, C = np.ascontiguousarray(G), np.ascontiguousarray(np.vstack([A, -rows]).T)
    scale = np.concatenate([np.ones(p), -1.0 / length])

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b if turn is None else turn.dot(b), lb, ub)
        try:
            x, _, _, iterations, _, _ = quadprog.solve_qp(G, a, C, scale * sides.right, p, factorized)
        except ValueError as error:
            return Answer(a, meaning(STATUS, str(error), "quadprog"))
        return Answer(x if back is None else back.dot(x), Status.SOLVED, int(iterations[0]))

    return solve
