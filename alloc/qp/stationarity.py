"""How far the thrusts of a soft problem lie from its optimum, quickly enough to be asked at every call.

Without its slacks, s = A x - b, the soft problem is min 1/2 x'M x - c'x within bounds, with M = H + A'QA and
c = A'Q b. With r = M x - c, x is optimal where every r_i is 0, or x_i at the bound that r_i pushes it to.
Near the optimum x and r tell which bounds hold; with these x_i fixed, the others follow from one linear
system. Where that point meets the condition it is the optimum, because M is positive definite, and the
distance to it is known exactly.
"""

from math import inf

import numpy as np

from alloc.allocation import FloatArray
from alloc.qp.problem import QP

STEPS = 20
"""Most guesses of the bounds that hold. Near the optimum the first is right; from anywhere inside the limits
five were the most that were seen."""
ROUNDING = 1e-12
"""How far x may lie beyond a bound, in the largest unit, or r push the wrong way, relative to its largest
entry [-]."""


class Stationarity:
    """The distance to the optimum, for one soft problem."""

    def __init__(self, qp: QP, unit: FloatArray) -> None:
        """Prepare M for thrusts in units of ``unit`` (m,); the slacks are the variables without bounds."""
        m = len(qp.bounded)
        self._share = unit / unit.max()
        A, Q = qp.A[:, :m], qp.H[m:, m:]
        self._c_of_b: FloatArray = A.T @ Q
        self._M: FloatArray = qp.H[:m, :m] + self._c_of_b @ A
        self._newton = 1.0 / np.diag(self._M)

    def distance(self, x: FloatArray, b: FloatArray, lb: FloatArray, ub: FloatArray) -> float:
        """Largest |x_i - x*_i| in the largest unit, x (m,) inside lb and ub (m,); inf if x* is not found."""
        M, c = self._M, self._c_of_b.dot(b)
        tiny = ROUNDING * np.abs(c).max()
        near = x
        r = M.dot(x) - c
        for _ in range(STEPS):
            aim = near - self._newton * r
            low, high = aim <= lb, aim >= ub
            near = np.where(low, lb, ub)
            free = np.flatnonzero(~(low | high))
            if free.size:
                near[free] = 0.0
                near[free] = np.linalg.solve(M[free[:, None], free], (c - M.dot(near))[free])
            r = M.dot(near) - c
            inside = (self._share * np.maximum(lb - near, near - ub) <= ROUNDING).all()
            if inside and (r[low] >= -tiny).all() and (r[high] <= tiny).all():
                return float((self._share * np.abs(x - near)).max())
        return inf
