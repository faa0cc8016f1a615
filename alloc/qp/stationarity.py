"""How far the thrusts of a soft problem lie from its optimum, quickly enough to be asked at every call.

Without its slacks, s = A x - b, the soft problem is min 1/2 x'M x - c'x within bounds, with M = H + A'QA and
c = A'Q b. With r = M x - c, x is optimal where every r_i is 0, or x_i at the bound that r_i pushes it to.
Near the optimum x and r tell which bounds hold; with these x_i fixed, the others follow from one linear
system. Where that point meets the condition it is the optimum, because M is positive definite, and the
distance to it is known exactly. Elsewhere bounds are added and dropped one by one (the primal active-set
method, which ends for every such problem).
"""

from math import inf

import numpy as np

from alloc.allocation import FloatArray
from alloc.qp.problem import QP

STEPS = 200
"""Most linear systems of one call, against rounding that would go round in circles. Near the optimum the
first one is enough."""
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
        """Largest |x_i - x*_i| in the largest unit, x (m,) inside lb and ub (m,); inf without x*."""
        M, c = self._M, self._c_of_b.dot(b)
        tiny = ROUNDING * np.abs(c).max()
        aim = x - self._newton * (M.dot(x) - c)
        low, high = aim <= lb, aim >= ub
        near = np.where(low, lb, np.where(high, ub, x))
        for _ in range(STEPS):
            free = np.flatnonzero(~(low | high))
            goal = near.copy()
            if free.size:
                goal[free] = 0.0
                goal[free] = np.linalg.solve(M[free[:, None], free], (c - M.dot(goal))[free])
            if (self._share * np.maximum(lb - goal, goal - ub) <= ROUNDING).all():
                near, r = goal, M.dot(goal) - c
                away = np.where(low, -r, np.where(high, r, 0.0))  # from a bound that does not hold after all
                worst = int(np.argmax(away))
                if away[worst] <= tiny:
                    return float((self._share * np.abs(x - near)).max())
                low[worst] = high[worst] = False
            else:
                near, first = _until_a_bound(near, goal - near, lb, ub)
                low[first], high[first] = near[first] == lb[first], near[first] == ub[first]
        return inf


def _until_a_bound(x: FloatArray, move: FloatArray, lb: FloatArray, ub: FloatArray) -> tuple[FloatArray, int]:
    """Where x + t move meets its first bound, and which that is."""
    bound = np.where(move > 0.0, ub, lb)
    with np.errstate(divide="ignore", invalid="ignore"):  # what does not move meets no bound
        t = np.where(move == 0.0, inf, (bound - x) / move)
    first = int(np.argmin(t))
    met = x + t[first] * move
    met[first] = bound[first]
    return met, first
