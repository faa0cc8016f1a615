"""Readiness of each thruster from what a vehicle did: least squares on T diag(p) f = M a + C(v) v + drag.

Known are thrusts f that commands should have made, accelerations a and velocities v. Unknown are the
readiness p_i of each thruster (1 as expected, 0 off, -1 reversed), linear and quadratic drag of each axis,
none of them negative, what a current changes of it, and a constant wrench, as of weight. M has to be known:
without it mass, drag and readiness can all be scaled together (``estimate_ratios``).

Errors of an axis follow each other: rows are replaced by what they differ from rho times the row before,
with rho and the size of errors from the solution before (Cochrane and Orcutt 1949, J. American Statistical
Association 44). Intervals are those of the linear model, so they hold no error of M, f or the form of drag.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray, IndexArray
from alloc.errors import VehicleError
from alloc.vehicle.geometry import DOF

WINDOW_S = 20.0
"""Length of a window [s]."""
FEWEST = 4
"""Rows an unknown that a window needs at least."""
LEAST, MOST = -1.5, 2.0
"""Bounds of a readiness [-]; within them a healthy one is free to come out on either side of 1."""
INTERVAL = 1.96
"""Standard deviations of a 95 % interval."""
ACCUSED = 5.0
"""Standard deviations below MODEL from which a thruster is accused: with eight thrusters and windows of 20 s
chance alone accuses less than once in a thousand hours."""
MODEL = 0.9
"""Readiness that errors of mass and thrust curves may feign [-]."""
VAGUE = 0.5
"""Half-width of an interval from which nothing can be said of a thruster [-]."""
PASSES = 2
"""Solutions of a window: as if errors were independent and there was no current, then with what the first one
says of both. A third has intervals half as wide, which errors of interpolated velocities leave."""
DEPENDENT = 1e-6
"""Singular value, of the largest, below which a direction of unknowns left no trace in a window."""

Estimate = Callable[[Vehicle, FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Function of a vehicle, f, a and v that returns readiness (n,) and half-widths (n,) of its intervals."""


class WindowReadiness(NamedTuple):
    """Readiness of each thruster in one window.

    Attributes
    ----------
    begin, end : of the window [s]
    p : (n,) estimates [-]; NaN where the window says nothing
    half_width : (n,) of their 95 % intervals [-]; infinite where the window says nothing
    """

    begin: float
    end: float
    p: FloatArray
    half_width: FloatArray

    @property
    def is_vague(self) -> bool:
        """True if nothing can be said of any thruster."""
        return not (self.half_width < VAGUE).any()

    @property
    def accused(self) -> list[int]:
        """Thrusters that are weaker than chance and errors of the model explain."""
        above = self.p + ACCUSED / INTERVAL * self.half_width
        return np.flatnonzero((self.half_width < VAGUE) & (above < MODEL)).tolist()


def estimate_windows(
    vehicle: Vehicle, t: FloatArray, f: FloatArray, a: FloatArray, v: FloatArray, estimate: Estimate
) -> Iterator[WindowReadiness]:
    """Readiness in windows of WINDOW_S: thrusts f (N, n) [N], a and v (N, k) in SI, times t (N,) [s].

    ``estimate`` is ``estimate_readiness``, or ``estimate_ratios`` where the mass is not known. A window that
    is shorter, or has too few rows, is left out.
    """
    unknowns = vehicle.n + 5 * vehicle.k
    edges = np.arange(t[0], t[-1] + 1e-9, WINDOW_S) if len(t) else np.empty(0)
    v = neighbour_velocity(t, a, v)
    for begin in edges.tolist():
        rows = (t >= begin) & (t < begin + WINDOW_S)
        if rows.sum() * vehicle.k < FEWEST * unknowns or t[rows][-1] - begin < WINDOW_S / 2:
            continue
        p, half_width = estimate(vehicle, f[rows], a[rows], v[rows])
        yield WindowReadiness(begin, float(t[rows][-1]), p, half_width)


def estimate_readiness(
    vehicle: Vehicle, f: FloatArray, a: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Readiness p (n,) and half-widths (n,) of its 95 % intervals, from rows of one window.

    Raises VehicleError for a vehicle without ``inertia``.
    """
    if vehicle.inertia is None:
        raise VehicleError(f"{vehicle.name}: has no 'inertia'; ask estimate_ratios", "inertia")
    which = [DOF.index(axis) for axis in vehicle.dof]
    inertia, k, n = vehicle.inertia[which], vehicle.k, vehicle.n
    b = inertia * a + coriolis(vehicle, inertia, v)
    low, high = np.quantile(v, (0.1, 0.9), axis=0)  # so slow that drag changes its sign in the window
    current, rho, spread = np.zeros(k), np.zeros(k), np.ones(k)
    for _ in range(PASSES):
        A, lower, upper = columns(vehicle, f, v - current)
        rows = whiten(A, rho[:, None], spread[:, None]).reshape(-1, A.shape[-1])
        right = whiten(b, rho, spread).ravel()
        x = _solve_bounded(rows, right, lower, upper)
        rho, spread = persistence(b - A @ x, b)
        quadratic, along = x[n + k : n + 2 * k], x[n + 3 * k :]
        is_felt = (quadratic > 0.0) & np.isin(which, range(3))
        current -= np.where(is_felt, along / (2.0 * np.where(is_felt, quadratic, 1.0)), 0.0)
        current = np.clip(current, np.minimum(low, 0.0), np.maximum(high, 0.0))
    half_width = INTERVAL * deviations(rows, right - rows @ x, np.eye(len(x))[:n])
    return np.where(np.isinf(half_width), np.nan, x[:n]), half_width


def neighbour_velocity(t: FloatArray, a: FloatArray, v: FloatArray) -> FloatArray:
    """Velocity (N, k) of each row from the rows before and after it, and how its slope a changes at the row.

    Feedback puts the noise of a row's own velocity into its thrusts: with it, readiness would be biased. The
    slope may jump, since thrusts do. The first and the last row keep their own.
    """
    before, after = (t[1:-1] - t[:-2])[:, None], (t[2:] - t[1:-1])[:, None]
    found, span = v.copy(), np.maximum(before + after, 1e-9)  # rows may have one time
    found[1:-1] += (after * (v[:-2] - v[1:-1]) + before * (v[2:] - v[1:-1])) / span
    found[1:-1] -= before * after / span * (a[1:-1] - a[:-2])
    return found


def columns(vehicle: Vehicle, f: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A (N, k, m) of A x = M a + C(v) v, and bounds (m,) of x.

    x is p, then linear drag, quadratic drag and constant of each axis, and a factor of |v|: with a current c
    drag is (v - c)|v - c|, which is v|v| - 2 c|v| to first order; ``v`` may be less a current that is
    nearly known, and the factor is what the rest of it changes.
    """
    N, k, n = len(f), vehicle.k, vehicle.n
    pushed = vehicle.T * f[:, None, :]  # (N, k, n)
    axes = np.eye(k)
    ones = np.ones((N, k))
    drag = [-axes * each[:, None, :] for each in (v, np.abs(v) * v, ones, np.abs(v))]
    lower = np.concatenate([np.full(n, LEAST), np.zeros(2 * k), np.full(2 * k, -np.inf)])
    upper = np.concatenate([np.full(n, MOST), np.full(4 * k, np.inf)])
    return np.concatenate([pushed, *drag], axis=2), lower, upper


def coriolis(vehicle: Vehicle, inertia: FloatArray, v: FloatArray) -> FloatArray:
    """C(v) v (N, k) of a diagonal M (k,): w x (M1 u); w x (M2 w) + u x (M1 u) (Fossen 2021, ch. 6)."""
    which = [DOF.index(axis) for axis in vehicle.dof]
    whole = np.zeros((2, len(v), 6))
    whole[:, :, which] = inertia * v, v
    momentum, spin, u, w = (part for each in whole for part in np.hsplit(each, 2))
    turning: FloatArray = np.hstack([np.cross(w, momentum), np.cross(w, spin) + np.cross(u, momentum)])
    return turning[:, which]


def persistence(errors: FloatArray, known: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Share rho (k,) of the row before in errors (N, k), and size (k,) of the rest."""
    before, after = errors[:-1], errors[1:]
    power = (before**2).sum(axis=0)
    rho = np.clip((before * after).sum(axis=0) / np.where(power > 0, power, 1.0), 0.0, 0.99)
    spread = np.sqrt(((after - rho * before) ** 2).mean(axis=0))
    return rho, np.maximum(spread, 1e-9 * float(np.abs(known).max()) + 1e-12)


def whiten(rows: FloatArray, rho: FloatArray, spread: FloatArray) -> FloatArray:
    """Rows (N - 1, ...) less rho of the row before, over the size of their errors."""
    return (rows[1:] - rho * rows[:-1]) / spread


def _solve_bounded(A: FloatArray, b: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Bounded least squares with columns of unit length; R of A and b has the same answer, in few rows."""
    from scipy.optimize import lsq_linear

    size = np.linalg.norm(A, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    R = np.asarray(np.linalg.qr(np.column_stack([A / size, b]), mode="r"))
    x: FloatArray = lsq_linear(R[:, :-1], R[:, -1], (lower * size, upper * size), method="bvls").x / size
    return x


def deviations(A: FloatArray, errors: FloatArray, G: FloatArray) -> FloatArray:
    """Standard deviations of G x from rows A (N, m) with errors (N,); infinite where they leave it open."""
    size = np.linalg.norm(A, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    _, sigma, Vt = np.linalg.svd(np.linalg.qr(A / size, mode="r"))
    kept = sigma > DEPENDENT * sigma.max(initial=0.0)
    free, G = max(len(A) - int(kept.sum()), 1), G / size
    is_open = ((G @ Vt[~kept].T) ** 2).sum(axis=1) > DEPENDENT * (G**2).sum(axis=1)
    known = ((G @ Vt[kept].T / sigma[kept]) ** 2).sum(axis=1)
    return np.where(is_open, np.inf, np.sqrt(errors @ errors / free * known))


def as_text(vehicle: Vehicle, windows: list[WindowReadiness]) -> str:
    """Lines of ``demands --accelerations``: readiness by window, then the thrusters that are accused."""
    lines = []
    for each in windows:
        cells = [
            f"{vehicle.called(i)} " + (f"{p:.2f} ± {half:.2g}" if half < VAGUE else "not known")
            for i, (p, half) in enumerate(zip(each.p.tolist(), each.half_width.tolist(), strict=True))
        ]
        lines.append(f"{each.begin:g} … {each.end:g} s  {', '.join(cells)}")
    for i in range(vehicle.n):
        where = [each for each in windows if i in each.accused]
        if where:
            p = float(np.median([each.p[i] for each in where]))
            lines.append(f"weak  {vehicle.called(i)}: {p:.2f} in {len(where)} of {len(windows)} windows")
    if not any(each.accused for each in windows):
        lines.append(f"weak  none: no readiness is surely below {MODEL:g}")
    return "\n".join(lines)


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

    T diag(p) f = M a + C(v) v + drag holds as well for any multiple of p, M and drag. Thrusters that push a
    common axis share that factor, so each readiness is reported over the median of the others in its group.
    The diagonal M is estimated too, by nonlinear least squares. Measured accelerations have errors; they
    stand alone on one side, a = M^-1 (T diag(p) f - C(v) v - drag), since a factor of M on them would pull
    its estimate towards zero. Intervals are those of the equations linearised at the answer.

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
        return whiten(model(x) - a, rho, spread).ravel()

    def rows(x: FloatArray, rho: FloatArray, spread: FloatArray) -> FloatArray:
        return whiten(slopes(x), rho[:, None], spread[:, None]).reshape(-1, len(x))

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
