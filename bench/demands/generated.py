"""Vehicles generated for studies and searches: growing, almost symmetric, and odd ones, and demands on them.

A published matrix is a symmetric vehicle printed to a few digits: columns that depend on each other in truth
do so up to the last digit only. Whoever divides by what is left of such a minor gets any thrust at all.
Random vehicles show none of this: they are either symmetric to the last bit, or not at all.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from alloc import NotApplicable, Status, Vehicle, build
from alloc.allocation import BoolArray, FloatArray
from alloc.errors import VehicleError
from alloc.reach.attainable import alpha_range
from alloc.vehicle.geometry import DOF
from bench.demands.sets.jolts import limited_demands

SIZES = {3: (4, 6, 8, 12, 16, 24, 32, 48, 64), 6: (8, 12, 16, 24, 32, 48, 64)}
"""Numbers of thrusters of the growth study, for each number of controlled degrees of freedom."""
AXES = {3: (0, 1, 5), 6: (0, 1, 2, 3, 4, 5)}
"""The controlled rows of a 6-DOF wrench, for each number of controlled degrees of freedom."""
RADIUS_M, LIMIT_N = 0.5, 50.0
"""About the size [m] and the thrust [N] of a small inspection vehicle."""


def growth_vehicles() -> list[Vehicle]:
    """Every vehicle of the growth study, which shows how time and memory of a method grow with n."""
    return [growth_vehicle(k, n) for k, sizes in SIZES.items() for n in sizes]


def growth_vehicle(k: int, n: int) -> Vehicle:
    """The vehicle of k degrees of freedom, 3 or 6, and n thrusters.

    Thrusters sit evenly on a circle (k = 3) or a sphere (k = 6) and push in seeded random
    directions, so that no two sizes share a special symmetry.
    """
    rng = np.random.default_rng([k, n])
    turn = np.arange(n) * np.pi * (3 - np.sqrt(5))  # the golden angle spreads points evenly on a sphere
    if k == 3:
        turn, height = 2 * np.pi * np.arange(n) / n, np.zeros(n)
    else:
        height = (2 * np.arange(n) + 1) / n - 1
    ring = np.sqrt(1 - height**2)
    positions = RADIUS_M * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    directions = rng.standard_normal((n, 3)) * ([1.0, 1.0, 0.0] if k == 3 else [1.0, 1.0, 1.0])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rows = np.vstack([directions.T, np.cross(positions, directions).T])
    return Vehicle(
        name=f"growth-k{k}-n{n}",
        dof=tuple(DOF[axis] for axis in AXES[k]),
        T=rows[list(AXES[k])],
        H=np.eye(n),
        f_min=np.full(n, -LIMIT_N),
        f_max=np.full(n, LIMIT_N),
        readiness=np.ones(n),
        slack_weights=np.full(k, 2000.0),
        source="generated for the growth study",
    )


STUDIES = {"growth": growth_vehicles}
"""The vehicles of each study, by its name."""


Poses = tuple[FloatArray, FloatArray]
"""Positions (n, 3) [m] and directions (n, 3) of unit length."""

PLANAR = (0, 1, 5)
"""Rows of T for a vehicle that is controlled in surge, sway and yaw only."""


def two_planes(rng: np.random.Generator) -> Poses:
    """Four canted vertical thrusters at (+-x, +-y), four horizontal ones turned by 45 degrees or less."""
    corners = np.array(list(product((1.0, -1.0), (1.0, -1.0), (1.0,))))
    cant, turn = rng.uniform(0.1, 0.6, 2), rng.choice([np.pi / 4, rng.uniform(0.3, 1.2)])
    upright = np.stack([corners[:, 0] * cant[0], corners[:, 1] * cant[1], np.ones(4)], axis=1)
    flat = np.stack([np.full(4, np.cos(turn)), corners.prod(axis=1) * np.sin(turn), np.zeros(4)], axis=1)
    places = [corners * rng.uniform(0.1, 0.6, 3) for _ in range(2)]
    return np.vstack(places), np.vstack([upright, flat])


def three_planes(rng: np.random.Generator) -> Poses:
    """Eight thrusters at (+-x, +-y, +-z), each the mirror image of its neighbours."""
    corners = np.array(list(product((1.0, -1.0), repeat=3)))
    return corners * rng.uniform(0.1, 0.6, 3), corners * rng.uniform(0.2, 1.0, 3)


def one_plane(rng: np.random.Generator) -> Poses:
    """Three or four thrusters anywhere, their mirror images to starboard, and up to two amidships."""
    pairs, amidships = int(rng.integers(3, 5)), int(rng.integers(0, 3))
    places, pushes = rng.uniform(-0.5, 0.5, (pairs, 3)), rng.normal(size=(pairs, 3))
    middle, along = rng.uniform(-0.5, 0.5, (amidships, 3)), rng.normal(size=(amidships, 3))
    middle[:, 1] = along[:, 1] = 0.0
    mirror = np.array([1.0, -1.0, 1.0])
    return np.vstack([places, places * mirror, middle]), np.vstack([pushes, pushes * mirror, along])


def in_the_plane(rng: np.random.Generator) -> Poses:
    """Four thrusters at the corners of a rectangle, and up to two more on its long axis."""
    corners = np.array(list(product((1.0, -1.0), (1.0, -1.0), (0.0,))))
    turn, more = rng.uniform(0.3, 1.2), int(rng.integers(0, 3))
    pushes = np.stack([np.full(4, np.cos(turn)), corners[:, 0] * corners[:, 1], np.zeros(4)], axis=1)
    ends = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])[:more]
    return np.vstack([corners * rng.uniform(0.1, 0.6, 3), ends]), np.vstack(
        [pushes, np.tile([[0, 1.0, 0]], (more, 1))]
    )


def repeated(rng: np.random.Generator) -> Poses:
    """A mirrored vehicle with one thruster twice, or with two that pull against each other in one line."""
    places, pushes = two_planes(rng) if rng.integers(2) else one_plane(rng)
    again = rng.integers(len(places), size=1)
    return np.vstack([places, places[again]]), np.vstack([pushes, pushes[again] * rng.choice([1.0, -1.0])])


FAMILIES: tuple[Callable[[np.random.Generator], Poses], ...] = (
    two_planes,
    three_planes,
    one_plane,
    in_the_plane,
    repeated,
)


def near_degenerate(
    rng: np.random.Generator, e: float | None = None, zeros: bool = False, ahead: bool = False
) -> Vehicle:
    """A vehicle that is symmetric but for ``e``, or for about 10^-3 ... 10^-15 where that is left out.

    In turn the entries of T are moved by up to e, the poses are, or either is rounded to as many decimals;
    with e = 0 nothing is. In every sixth vehicle the last axis is all but lost. With ``zeros`` entries of T
    that are zero are moved too. With ``ahead`` no thruster reverses: no thrust is a vertex of what they do.
    """
    family = FAMILIES[int(rng.integers(len(FAMILIES)))]
    places, pushes = family(rng)
    e = 10.0 ** -rng.uniform(3, 15) if e is None else e
    how = int(rng.integers(4)) if e else -1
    if how in (1, 3):
        places, pushes = (_moved(each, e, rng, rounded=how == 3) for each in (places, pushes))
    pushes = pushes / np.linalg.norm(pushes, axis=1, keepdims=True)
    axes = PLANAR if family is in_the_plane else range(6)
    T = np.vstack([pushes.T, np.cross(places, pushes).T])[list(axes)]
    T[np.abs(T) < 1e-15] = 0.0
    if rng.integers(6) == 0:
        T[-1] = T[0] * 0.3 + T[-1] * 10.0 ** -rng.uniform(1, 5)
    if how in (0, 2):
        T = _moved(T, e, rng, rounded=how == 2)
    if zeros:
        T = T + e * rng.uniform(-1, 1, T.shape)
    k, n = T.shape
    high = np.full(n, 60.0)
    high *= rng.uniform(0.3, 1.3, n) if rng.integers(2) else 1.0
    reversing = rng.choice([1.0, 2 / 3, 0.0], n, p=[0.3, 0.6, 0.1])
    low = -high * (reversing if rng.integers(4) == 0 else reversing[0]) * (not ahead)
    weights = rng.choice([1.0, 2.0], n) if rng.integers(4) == 0 else np.ones(n)
    return Vehicle(
        name=f"near-{family.__name__.replace('_', '-')}",
        dof=tuple(DOF[axis] for axis in axes),
        T=T,
        H=np.diag(weights),
        f_min=low,
        f_max=high,
        readiness=np.ones(n),
        slack_weights=np.full(k, 2000.0),
        priority=(
            tuple(DOF[axis] for axis in list(axes)[k // 2 :]),
            tuple(DOF[axis] for axis in list(axes)[: k // 2]),
        ),
        source="generated: symmetric but for its last digits",
        weak_limit=0.0,  # what is asked is what rounding does where a direction is all but lost
    )


def numbered(number: int) -> tuple[Vehicle, np.random.Generator]:
    """A numbered vehicle of this kind, and what its demands are drawn from.

    Of each nine one has zeros moved, one does not reverse, and one has both.
    """
    rng = np.random.default_rng([29, number])
    return near_degenerate(rng, zeros=number % 9 in (2, 8), ahead=number % 9 in (2, 6)), rng


def edge_demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m] on vertices, edges and faces, shortened, as they are, and beyond.

    Half of the thrusts that make them stand at the limits which a direction favours, so that the wrench is on
    the edge of the attainable set: a random direction, or one at right angles to k - 1 thrusters, whose
    thrusts are then free. The others stand at limits at random, but for up to k that are free. Some lie
    beyond by 2e-5 to 2e-11 of the way: powers of ten are where verdicts change.
    """
    k, on = vehicle.k, vehicle.working
    scaled = vehicle.TP[:, on] / vehicle.wrench_scale[:, None]
    F = np.zeros((n, vehicle.n))
    for i, f in enumerate(F):
        along = rng.normal(size=len(on))
        free = rng.choice(len(on), min(int(rng.integers(0, k)), len(on)), replace=False)
        if i % 2:
            spanning = rng.choice(len(on), min(k - 1, len(on)), replace=False)
            normal = np.linalg.svd(scaled[:, spanning].T)[2][-1] if i % 4 == 1 else rng.normal(size=k)
            along = normal @ scaled
            free = np.flatnonzero(np.abs(along) < 1e-14) if i % 8 == 5 else free[:0]
            if i % 8 == 1:
                free = spanning[: int(rng.integers(0, k))]
        f[on] = np.where(along > 0, vehicle.f_max[on], vehicle.f_min[on])
        f[on[free]] = rng.uniform(vehicle.f_min[on[free]], vehicle.f_max[on[free]])
    length, number = rng.choice([0.5, 0.999, 1.0, 1.3], n), np.arange(n)
    length += np.where((length == 1.0) & (number % 3 == 2), 2.0 * 10.0 ** -(5 + number % 7), 0.0)
    taus: FloatArray = F @ vehicle.TP.T * length[:, None]
    return taus


def _moved(values: FloatArray, e: float, rng: np.random.Generator, rounded: bool) -> FloatArray:
    """Values rounded to about that many decimals, or those that are not zero moved by up to e."""
    if rounded:
        return values.round(int(np.clip(np.rint(-np.log10(e)), 3, 12)))
    by: FloatArray = np.where(values != 0, e * rng.uniform(-1, 1, values.shape), 0.0)
    return values + by


MOST_DECADES = 8.0
"""Decimal powers by which the weights of H are apart, at most."""

DEMANDS = 50
"""Demands of a vehicle within its own limits, and as many within others."""
EDGE = 1e-6
"""Share by which a demand must lie inside the edge to count as attainable, by the facets alone."""
FACTORS = (1.0, 1.0, 1 - 1e-5, 0.5, 1 + 1e-5, 2.0)
"""Factors on demands that thrusts inside the limits push."""


def odd_vehicle(rng: np.random.Generator) -> Vehicle:
    """A vehicle of 1 to 6 DOF and up to four thrusters more, some alike, weakened, stuck or one-sided."""
    k = int(rng.integers(1, 7))
    n = k + int(rng.integers(0, 4 if k > 3 else 5))
    T = rng.normal(size=(k, n)) * 10.0 ** rng.uniform(-1, 1, (k, 1))
    if rng.integers(3) == 0:
        T = np.round(T * 2) / 2  # directions that repeat and cancel, as those of symmetric layouts
        T[:, :k] += np.eye(k)
    if n > k and rng.integers(4) == 0:
        T[:, -1] = T[:, 0] * rng.choice([1.0, -1.0, 0.5])  # two thrusters in one line
    if not T.any():
        T[0, 0] = 1.0
    high = 10.0 ** rng.uniform(0, 3) * rng.uniform(0.5, 2, n)
    low = -high * rng.choice([1.0, 0.6, 0.0, -0.05], n, p=[0.5, 0.2, 0.2, 0.1])
    if rng.integers(4) == 0:
        low[0] = high[0] = 0.3 * high[0]  # stuck
    readiness = np.where(rng.random(n) < 0.1, 10.0 ** rng.uniform(-3, 0, n), 1.0)
    vehicle = Vehicle(
        name="odd",
        dof=DOF[:k],
        T=T,
        H=np.eye(n),
        f_min=low,
        f_max=high,
        readiness=readiness,
        slack_weights=np.full(k, 2000.0),
    )
    kind = int(rng.integers(3))
    decades = float(rng.uniform(0, MOST_DECADES))
    return vehicle if kind == 0 else weighted(vehicle, rng, decades, full=kind == 2)


def weighted(vehicle: Vehicle, rng: np.random.Generator, decades: float, full: bool) -> Vehicle:
    """The vehicle with random weights that far apart, on the diagonal, or as eigenvalues of a full H."""
    weights = 10.0 ** rng.permutation(np.linspace(0, decades, vehicle.n))
    if not full:
        return replace(vehicle, H=np.diag(weights))
    Q = np.linalg.qr(rng.normal(size=(vehicle.n, vehicle.n)))[0]
    H = Q * weights @ Q.T
    return replace(vehicle, H=(H + H.T) / 2)


def inside(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """Demands (n, k) that random thrusts inside the limits push, some with thrusters at their limits."""
    F = rng.uniform(vehicle.f_min, vehicle.f_max, (n, vehicle.n))
    at_end = rng.random(F.shape) < rng.choice([0.0, 0.3, 0.6], (n, 1))
    F = np.where(at_end, np.where(rng.random(F.shape) < 0.5, vehicle.f_min, vehicle.f_max), F)
    taus: FloatArray = F @ vehicle.TP.T
    return taus


def generate_vehicle(number: int) -> tuple[Vehicle, np.random.Generator]:
    """A numbered odd vehicle, some with a thruster off, and what its demands are drawn from."""
    rng = np.random.default_rng([2004, number])
    vehicle = odd_vehicle(rng)
    if number % 4 == 0:
        with suppress(VehicleError):  # the last thruster that pushes can't be taken off
            return vehicle.with_fault(number % vehicle.n), rng
    return vehicle, rng


class DemandsAsked(NamedTuple):
    """Demands of one vehicle within limits of one kind, and what is known of them.

    Attributes
    ----------
    taus : (N, k) [N, N m]
    low, high : (N, n) limits of each [N]
    own : whether these are the vehicle's
    attainable : (N,) whether some thrusts inside the limits push the demand, beyond doubt
    optimum : (N, n) the exact method's answer [N], NaN where there is none
    doubt : what that method promises, relative to the largest limit [-]
    """

    taus: FloatArray
    low: FloatArray
    high: FloatArray
    own: bool
    attainable: BoolArray
    optimum: FloatArray
    doubt: float

    def limits(self, count: int) -> tuple[FloatArray, ...]:
        """f_min and f_max of the first demands, nothing where they are the vehicle's."""
        return () if self.own else (self.low[:count], self.high[:count])


def drawn_demands(vehicle: Vehicle, rng: np.random.Generator) -> list[DemandsAsked]:
    """Demands within the vehicle's own limits, and within limits that jump."""
    factors = rng.choice(FACTORS, DEMANDS)
    taus = inside(vehicle, rng, DEMANDS) * factors[:, None]
    shape = (DEMANDS, vehicle.n)
    own = (taus, np.broadcast_to(vehicle.f_min, shape), np.broadcast_to(vehicle.f_max, shape))
    moved, low, high, _ = limited_demands(vehicle, rng, DEMANDS)
    pushed = (low <= high).all(axis=1) & (rng.random(DEMANDS) < 0.5)
    moved[pushed] = rng.uniform(low[pushed], high[pushed]) @ vehicle.TP.T
    sets = []
    for (demands, lows, highs), made in ((own, factors == 1.0), ((moved, low, high), pushed)):
        is_own = made is not pushed
        limits = () if is_own else (lows, highs)
        least, most = alpha_range(vehicle, demands, *limits)
        attainable = made | ((least <= 1 - EDGE) & (most >= 1 + EDGE))
        optimum, doubt = np.full(shape, np.nan), np.inf
        try:
            exact = build("nullspace", vehicle)
        except NotApplicable:
            pass
        else:
            F, status = exact.many(demands, *limits)
            optimum, doubt = np.where((status == Status.SOLVED)[:, None], F, np.nan), exact.tolerance
        sets.append(DemandsAsked(demands, lows, highs, is_own, attainable, optimum, doubt))
    return sets
