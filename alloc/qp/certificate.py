r"""Distance of x from the optimum, by the problem and x alone: no status, no solver's multipliers.

For any multiplier y of A x = b, the bounds' multipliers follow from stationarity, z = -(Hx + g + A'y),
split by sign. The duality gap of (x, y), in the problem whose b is ``A x`` so that x meets it, is

    gap(y) = sum_i max(z_i, 0) (ub_i - x_i) + max(-z_i, 0) (x_i - lb_i)

which complementary slackness asks to be 0. Variables without bounds (the slacks of a soft
problem) can't have a multiplier; the rest w of their stationarity costs 1/2 w' H_ss^-1 w instead.
The gap bounds the distance to that problem's optimum, 1/2 ||x - x*||_H^2 <= gap, for every y, so the
least gap is wanted. The gap is convex in y, and without slacks also piecewise linear, so it is least
where p of the z are 0: all such y are tried (at most 28 for 8 thrusters and 6 DOF), and the least gap
is exact, also at degenerate corners. With slacks up to p of the z are set to 0, and y is the cheapest
under that condition: the gap is then a valid bound, and 0 at the optimum.
"""

from dataclasses import dataclass
from itertools import chain, combinations
from math import comb, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray, IndexArray
from alloc.errors import NotApplicable
from alloc.qp.problem import QP

SINGULAR = 1e-10
"""A set of z fixes no y where its equations have a reciprocal condition below this. A scaled problem has
orthonormal rows and real geometry stays above 1e-3; the weights of the slacks cost another 1e-4."""
MOST_TRIED = 5_000
"""Most multipliers that are tried: 16 thrusters in 3 DOF, 12 in 6, take a second to prepare."""
CHUNK = 1_000_000
"""Numbers held at a time (8 MB): larger chunks are no faster, and memory bounds no demand set."""


class Certificate(NamedTuple):
    """Distances of an x, or of each of N, from optimal; all in the units of the QP, NaN for a NaN x.

    Attributes
    ----------
    primal : largest violation of A x = b or of a bound
    dual : largest |x - clip(x - (Hx + g + A'y), lb, ub)|, which is 0 at the optimum and only there
    complementarity : largest product of a bound's multiplier and the distance to that bound
    gap : duality gap
    distance : bound on max |x_i - x*_i| over the bounded x_i (the thrusts), where lb <= x <= ub and x*
        is the optimum for b = A x, the wrench that x does produce. The optimum for the b of the
        problem lies further away by no more than the optimum moves from A x to b, which vanishes
        with ``primal``.
    """

    primal: FloatArray
    dual: FloatArray
    complementarity: FloatArray
    gap: FloatArray
    distance: FloatArray


Bounds = tuple[FloatArray, FloatArray]
"""lb and ub of the bounded variables (``QP.bounded``), (q,) for all answers or (N, q)."""


def certify(qp: QP, b: ArrayLike, x: ArrayLike, bounds: Bounds | None = None) -> Certificate:
    """The certificate of one x (m,) as an answer to b (p,); ``bounds`` as in ``certify_many``."""
    many = certify_many(qp, np.atleast_2d(b), np.atleast_2d(x), bounds)
    return Certificate(*(values[0] for values in many))


def certify_many(qp: QP, B: ArrayLike, X: ArrayLike, bounds: Bounds | None = None) -> Certificate:
    """The certificates of X (N, m) as answers to B (N, p), row by row; each entry is (N,).

    ``bounds`` are those of the calls, where they are not the problem's. Raises NotApplicable for a QP with
    more than MOST_TRIED multipliers to try.
    """
    x, b = np.asarray(X, dtype=np.float64), np.asarray(B, dtype=np.float64)
    maps = _multipliers(qp)
    rows = max(1, CHUNK // maps.to_r[:, 0].size)
    lb, ub = (np.broadcast_to(side, (len(x), len(maps.bounded))) for side in bounds or _own_bounds(qp))
    chunks = [slice(i, i + rows) for i in range(0, max(1, len(x)), rows)]
    parts = [_certify(qp, maps, b[chunk], x[chunk], lb[chunk], ub[chunk]) for chunk in chunks]
    return Certificate(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _own_bounds(qp: QP) -> Bounds:
    return qp.lb[qp.bounded], qp.ub[qp.bounded]


@dataclass(frozen=True)
class _Multipliers:
    """S linear maps from r0 = Hx + g to stationarity Hx + g + A'y, one for each y that is tried.

    Attributes
    ----------
    bounded : (q,) indices of the variables with a bound
    to_r : (S, q, m) maps to the stationarity r of the bounded variables, whose z = -r
    to_w : (S, m - q, m) maps to that of the others, in units that make the cost 1/2 |w|^2
    reach : largest |e_i| of a bounded variable with A e = 0 and e'He = 1
    """

    bounded: IndexArray
    to_r: FloatArray
    to_w: FloatArray
    reach: float


def _multipliers(qp: QP) -> _Multipliers:
    if qp.sides is not None:
        raise NotApplicable("a certificate tries multipliers of bounds alone, and the problem has sides")
    p, m = qp.A.shape
    bounded = qp.bounded
    tried = sum(comb(len(bounded), j) for j in range(p + 1))
    if tried > MOST_TRIED:
        raise NotApplicable(
            f"a certificate for {len(bounded)} bounded variables and {p} equations has {tried} multipliers"
            f" to try, more than {MOST_TRIED}; compare with a reference instead"
        )
    free = np.setdiff1d(np.arange(m), bounded)
    # Minimising over the free variables first (H_ss = L L') leaves a problem in the bounded ones.
    L = np.linalg.cholesky(qp.H[np.ix_(free, free)])
    to_w = np.linalg.solve(L, np.eye(m)[free])
    coupling = np.linalg.solve(L, qp.H[np.ix_(free, bounded)])
    to_r = np.eye(m)[bounded] - coupling.T @ to_w
    a_r, a_w = to_r @ qp.A.T, to_w @ qp.A.T
    maps_r, maps_w = [], []
    for zeros in chain.from_iterable(combinations(range(len(bounded)), j) for j in range(p + 1)):
        if len(zeros) < p - len(free):
            continue
        # The y of least 1/2 |w|^2 with r = 0 at the indices in zeros, from the KKT conditions for it.
        index = list(zeros)
        edge = a_r[index]
        kkt = np.block([[a_w.T @ a_w, edge.T], [edge, np.zeros((len(index), len(index)))]])
        if np.linalg.cond(kkt) * SINGULAR > 1:
            continue
        y = np.linalg.solve(kkt, -np.vstack([a_w.T @ to_w, to_r[index]]))[:p]
        r = to_r + a_r @ y
        r[index] = 0.0  # without rounding, so that these entries cost nothing
        maps_r.append(r)
        maps_w.append(to_w + a_w @ y)
    N = np.linalg.svd(qp.A)[2][p:].T  # a basis of the null space: A has full row rank
    reach = np.diag(N @ np.linalg.solve(N.T @ qp.H @ N, N.T))[bounded].max(initial=0.0)
    return _Multipliers(bounded, np.array(maps_r), np.array(maps_w), float(np.sqrt(max(reach, 0.0))))


def _certify(
    qp: QP, maps: _Multipliers, b: FloatArray, x: FloatArray, lb: FloatArray, ub: FloatArray
) -> Certificate:
    S, q, m = maps.to_r.shape
    inside = x[:, maps.bounded]
    below, above = np.maximum(inside - lb, 0.0), np.maximum(ub - inside, 0.0)
    r0 = x @ qp.H + qp.g
    r = (r0 @ maps.to_r.reshape(S * q, m).T).reshape(len(x), S, q)
    w = (r0 @ maps.to_w.reshape(S * (m - q), m).T).reshape(len(x), S, m - q)
    with np.errstate(invalid="ignore"):  # 0 * infinity: no multiplier where there is no bound
        product = np.where(r == 0.0, 0.0, np.where(r > 0, r * below[:, None], -r * above[:, None]))
    gaps = product.sum(axis=2) + (w * w).sum(axis=2) / 2
    row, best = np.arange(len(x)), np.argmin(gaps, axis=1)
    gap, r, w = gaps[row, best], r[row, best], w[row, best]
    outside = np.maximum(np.maximum(lb - inside, inside - ub), 0.0)
    primal = np.abs(np.hstack([x @ qp.A.T - b, outside])).max(axis=1)
    dual = np.abs(np.hstack([inside - np.clip(inside - r, lb, ub), w])).max(axis=1)
    complementarity = product[row, best].max(axis=1)
    distance = maps.reach * np.sqrt(2 * gap)
    return Certificate(primal=primal, dual=dual, complementarity=complementarity, gap=gap, distance=distance)


STEPS = 200
"""Most linear systems of one call, against rounding that would go round in circles. Near the optimum the
first one is enough."""
ROUNDING = 1e-12
"""Distance by which x may lie beyond a bound, or r push the wrong way, relative to the largest entry [-]."""


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
    """First bound that x + t move meets, as its t and its index."""
    bound = np.where(move > 0.0, ub, lb)
    with np.errstate(divide="ignore", invalid="ignore"):  # what does not move meets no bound
        t = np.where(move == 0.0, inf, (bound - x) / move)
    first = int(np.argmin(t))
    met = x + t[first] * move
    met[first] = bound[first]
    return met, first
