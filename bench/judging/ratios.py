"""Ratios of readiness where a vehicle's mass is not known: nonlinear least squares on what it did.

T diag(p) f = M a + C(v) v + drag holds as well for any multiple of p, M and drag. Thrusters that push a
common axis share that factor, so each readiness is reported over the median of the others in its group. The
diagonal M is estimated too. Measured accelerations have errors; they stand alone on one side,
a = M^-1 (T diag(p) f - C(v) v - drag), since a factor of M on them would pull its estimate towards zero.
Errors that follow each other are taken out as in ``bench.judging.readiness``; intervals are those of the
equations linearised at the answer.
"""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray, IndexArray
from bench.judging.readiness import INTERVAL, columns, coriolis, deviations, persistence, whitened

LINKED = 0.3
"""Share of the largest entry of a row of T from which a thruster counts as pushing that axis."""
LIGHTEST, HEAVIEST = 0.02, 50.0
"""Bounds of an axis's inertia, relative to the one that all thrusters as expected would explain [-]."""
STEPS = 100
"""Most steps of the solver; a window of a moving vehicle takes about ten."""


def groups(vehicle: Vehicle) -> IndexArray:
    """Number (n,) of the group of each thruster; those that push a common axis have the same."""
    from scipy.sparse.csgraph import connected_components

    largest = np.abs(vehicle.T).max(axis=1, keepdims=True)
    pushes = np.abs(vehicle.T) >= LINKED * np.where(largest > 0.0, largest, np.inf)
    _, found = connected_components(pushes.T.astype(float) @ pushes, directed=False)
    return np.asarray(found, dtype=np.intp)


def estimate_ratios(
    vehicle: Vehicle, f: FloatArray, a: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Readiness (n,) over the median of the others in a group, and half-widths (n,) of its 95 % intervals.

    Shapes and units as of ``estimate_readiness``; ``vehicle.inertia`` is not read. NaN and infinity stand
    where the rows say nothing.
    """
    from scipy.optimize import least_squares

    n, k = vehicle.n, vehicle.k
    A, lower, upper = columns(vehicle, f, v)
    turning = np.stack([coriolis(vehicle, axis, v) for axis in np.eye(k)], axis=2)  # (N, k, k)
    start = _start(vehicle, f, a)
    if not (start > 0.0).all():  # an axis that did not move
        return np.full(n, np.nan), np.full(n, np.inf)

    def model(x: FloatArray) -> FloatArray:
        """Accelerations (N, k)."""
        found: FloatArray = (A @ x[:-k] - turning @ x[-k:]) / x[-k:]
        return found

    def slopes(x: FloatArray) -> FloatArray:
        """Their derivatives (N, k, m)."""
        M = x[-k:, None]
        return np.concatenate([A / M, -turning / M - np.eye(k) * model(x)[:, None, :] / M], axis=2)

    x = np.concatenate([np.ones(n), np.zeros(A.shape[-1] - n), start])
    bounds = np.append(lower, LIGHTEST * start), np.append(upper, HEAVIEST * start)

    def errors(x: FloatArray, rho: FloatArray, spread: FloatArray) -> FloatArray:
        return whitened(model(x) - a, rho, spread).ravel()

    def rows(x: FloatArray, rho: FloatArray, spread: FloatArray) -> FloatArray:
        return whitened(slopes(x), rho[:, None], spread[:, None]).reshape(-1, len(x))

    rho, spread = np.zeros(k), np.ones(k)
    for _ in range(2):  # as if errors were independent of the row before, then with what follows from it
        solved = least_squares(errors, x, rows, bounds, x_scale="jac", max_nfev=STEPS, args=(rho, spread))
        if solved.status == 0:  # nothing is claimed of what did not settle
            return np.full(n, np.nan), np.full(n, np.inf)
        x = solved.x
        rho, spread = persistence(model(x) - a, a)
    ratios, G = _ratios(x[:n], groups(vehicle))
    spreads = deviations(rows(x, rho, spread), errors(x, rho, spread), np.pad(G, ((0, 0), (0, len(x) - n))))
    is_known = np.isfinite(ratios) & np.isfinite(spreads)
    return np.where(is_known, ratios, np.nan), np.where(is_known, INTERVAL * spreads, np.inf)


def _start(vehicle: Vehicle, f: FloatArray, a: FloatArray) -> FloatArray:
    """Inertia (k,) that explains most if all thrusters are as expected and there is no drag."""
    wrench = f @ vehicle.T.T
    power = (a**2).sum(axis=0)
    size: FloatArray = (wrench**2).sum(axis=0) / np.where(power > 0.0, power, np.inf)
    return np.sqrt(size)


def _ratios(p: FloatArray, group: IndexArray) -> tuple[FloatArray, FloatArray]:
    """Each p (n,) over the median of the others in its group, NaN if alone, and the derivatives (n, n)."""
    n = len(p)
    middle = np.zeros((n, n))  # weights of the medians
    for i in range(n):
        others = np.flatnonzero((group == group[i]) & (np.arange(n) != i))
        ranked = others[np.argsort(p[others])]
        if len(ranked):
            np.add.at(middle[i], [ranked[(len(ranked) - 1) // 2], ranked[len(ranked) // 2]], 0.5)
    median = middle @ p
    ratios = p / np.where(median == 0.0, np.nan, median)
    return ratios, (np.eye(n) - ratios[:, None] * middle) / np.where(median == 0.0, np.nan, median)[:, None]


def group_text(vehicle: Vehicle) -> str:
    """Line in front of the windows: numbers are ratios, and of which thrusters."""
    found = groups(vehicle)
    members = [
        ", ".join(vehicle.called(i) for i in np.flatnonzero(found == g).tolist())
        for g in range(int(found.max()) + 1)
    ]
    return (
        f"ratios  {vehicle.name} has no 'inertia': mass, drag and readiness could all be scaled together, so"
        " each number is a thruster's readiness over the median of the others that push with it"
        f" ({'; '.join(members)})"
    )
