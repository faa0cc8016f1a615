"""Right-hand sides that are written in place, bounds only where a call brings new ones."""

import numpy as np

from alloc.allocation import FloatArray
from alloc.qp.problem import QP


class TwoSided:
    """low <= [A; I] x <= high, with the rows of I that bound something.

    Attributes
    ----------
    low, high : (p + q,) the first p are b, the other q are bounds
    """

    def __init__(self, qp: QP) -> None:
        """Begin with the bounds of the problem, and b = 0."""
        bounded = qp.bounded
        self._p = len(qp.A)
        self._held = qp.lb[bounded], qp.ub[bounded]
        self.low, self.high = (np.concatenate([np.zeros(self._p), side]) for side in self._held)

    def put(self, b: FloatArray, lb: FloatArray, ub: FloatArray) -> None:
        """Write b (p,) and the bounds (q,) of the bounded variables."""
        low, high, p = self.low, self.high, self._p
        low[:p] = high[:p] = b
        if lb is not self._held[0] or ub is not self._held[1]:
            low[p:], high[p:] = lb, ub
            self._held = lb, ub


class OneSided:
    """A x = b and G x <= h, with G and h of ``QP.one_sided``: [A; G] beside ``right`` = [b; h].

    Attributes
    ----------
    right : (p + g,) the first p are b, then the finite upper bounds, then the negated lower ones
    """

    def __init__(self, qp: QP) -> None:
        """Begin with the bounds of the problem, and b = 0."""
        bounded = qp.bounded
        self._p = len(qp.A)
        self._held = qp.lb[bounded], qp.ub[bounded]
        self._lower, self._upper = (np.flatnonzero(np.isfinite(side)) for side in self._held)
        self._middle = self._p + len(self._upper)
        self.right = np.concatenate([np.zeros(self._p), qp.one_sided[1]])

    def put(self, b: FloatArray, lb: FloatArray, ub: FloatArray) -> None:
        """Write b (p,) and the bounds (q,) of the bounded variables."""
        right = self.right
        right[: self._p] = b
        if lb is not self._held[0] or ub is not self._held[1]:
            right[self._p : self._middle] = ub[self._upper]
            np.negative(lb[self._lower], out=right[self._middle :])
            self._held = lb, ub
