"""A QP with a full H in variables in which H is the identity, y = L'x with H = L L'.

Units of their own even out a diagonal H, not a full one. The price is that bounds become rows,
lb <= L'^-1 y <= ub, so it pays for solvers that know no bounds, only rows.
"""

from dataclasses import dataclass

import numpy as np

from alloc.allocation import FloatArray
from alloc.qp.problem import QP


@dataclass(frozen=True, eq=False, kw_only=True)
class Whitened:
    """min 1/2 y'y + g'y subject to A y = turn b, and bounds on x = back y.

    Attributes
    ----------
    g : (m,) linear part of the cost
    A : (p, m) orthonormal rows
    turn : (p, p) map of the right side b
    back : (m, m) map from y to x
    """

    g: FloatArray
    A: FloatArray
    turn: FloatArray
    back: FloatArray


def whitened(qp: QP) -> Whitened | None:
    """The problem in such variables; None where H is diagonal, and units are enough."""
    if np.array_equal(qp.H, np.diag(np.diag(qp.H))):
        return None
    back = np.linalg.inv(np.linalg.cholesky(qp.H)).T
    Q, R = np.linalg.qr((qp.A @ back).T)
    return Whitened(g=back.T @ qp.g, A=Q.T, turn=np.linalg.inv(R.T), back=back)
