"""Attainable set {T P f : f_min <= f <= f_max} as inequalities: a zonotope and its facets.

A linear image of a box is a zonotope (McMullen 1971; for allocation Durham 1994, "Attainable
moments for the constrained control allocation problem"). Each facet is spanned by r - 1 of its
generators, so the normals of all (r - 1)-subsets include that of every facet.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from math import comb

import numpy as np

from alloc.allocation import FloatArray
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.azimuth import HalfPlanes, refuse_azimuths
from alloc.vehicle.degeneracy import FLAT, NOTHING, independent
from alloc.vehicle.pieces import combinations as combinations_of


@dataclass(frozen=True, eq=False, kw_only=True)
class Zonotope:
    """The wrenches tau with facets (tau / scale) <= support.

    Attributes
    ----------
    facets : (M, k) unit outward normals in scaled wrench; a direction in which the set has no extent
        contributes two opposite normals
    support : (M,) how far the set reaches along each normal
    tolerance : (M,) largest |c't| at which a unit direction t counts as parallel to the facet with
        normal c: rounding, or the tolerance of a rank for directions without extent
    scale : (k,) the vehicle's ``wrench_scale`` [N, N m]
    center : (k,) centre of the set [N, N m]
    generators : (k, m) the set is center + generators [-1, 1]^m [N, N m]
    dimension : number of independent directions in which the set has extent
    """

    facets: FloatArray
    support: FloatArray
    tolerance: FloatArray
    scale: FloatArray
    center: FloatArray
    generators: FloatArray
    dimension: int


@lru_cache(maxsize=64)  # every demand set on a vehicle asks for its facets
def zonotope(vehicle: Vehicle) -> Zonotope:
    """Facets of the attainable set of this vehicle, its limits and its faults.

    Exact: support(c) = sum over thrusters of max(c'T_i f_min_i, c'T_i f_max_i) for every normal c. A
    normal to generators that nearly lie in fewer dimensions belongs to no facet; its inequality holds too.
    Of a thruster that turns the sides of its polygon are generators, which span the facets as others do, and
    its support is the largest over the polygon's corners; the set is then no zonotope.
    """
    scale = vehicle.wrench_scale
    center = vehicle.TP @ (vehicle.f_min + vehicle.f_max) / 2
    generators = vehicle.TP * (vehicle.f_max - vehicle.f_min) / 2
    if vehicle.azimuths:
        generators = vehicle.TP @ edges(vehicle) / 2
    generators = generators[:, generators.any(axis=0)]
    scaled = generators / scale[:, None]
    U, sigma, _ = np.linalg.svd(scaled)
    r = independent(sigma, max(sigma.max(initial=0.0), NOTHING))
    normals = _normals(U[:, :r].T @ scaled) @ U[:, :r].T
    across = U[:, r:].T
    half = np.vstack([normals, across])
    reach = np.concatenate([np.abs(normals @ scaled).sum(axis=1), np.zeros(len(across))])
    middle = half @ (center / scale)
    support = np.concatenate([middle + reach, reach - middle])
    if vehicle.azimuths:
        pushed = np.vstack([half, -half]) @ (vehicle.TP / scale[:, None])
        support = farthest(vehicle, pushed)
    return Zonotope(
        facets=np.vstack([half, -half]),
        support=np.where(np.abs(support) <= NOTHING, 0.0, support),
        tolerance=np.tile(np.repeat([NOTHING, RANK_TOLERANCE], [len(normals), len(across)]), 2),
        scale=scale,
        center=center,
        generators=generators,
        dimension=r,
    )


def edges(vehicle: Vehicle) -> FloatArray:
    """(n, m) edges of the sets of thrusts: widths of limits, and sides of polygons [N].

    Of sides that are parallel the first stands for all.
    """
    turning = [i for azimuth in vehicle.azimuths for i in azimuth.components]
    widths = np.delete(np.diag(vehicle.f_max - vehicle.f_min), turning, axis=1)
    columns = [widths]
    for azimuth in vehicle.azimuths:
        sides = np.zeros((vehicle.n, len(azimuth.distinct)))
        along = np.roll(azimuth.corners, -1, axis=0) - azimuth.corners
        sides[azimuth.components] = along[azimuth.distinct].T
        columns.append(sides)
    return np.hstack(columns)


def candidates(vehicle: Vehicle) -> int:
    """Number of subsets of thrusters, or of edges where some turn, that may span a facet.

    Of several combinations of convex pieces it is the largest number.
    """
    spanning = max(vehicle.rank - 1, 0)
    if not vehicle.azimuths:
        return comb(len(vehicle.working), spanning)
    return max(comb(edges(one).shape[1], spanning) for one in combinations_of(vehicle))


def farthest_thrusts(
    vehicle: Vehicle, along: FloatArray, limits: tuple[FloatArray, FloatArray] | None = None
) -> FloatArray:
    """Thrusts f (M, n) [N] within limits that make along'f largest, for M rows ``along`` (M, n).

    Limits are f_min and f_max, (n,) or (M, n); left out, the vehicle's.
    """
    low, high = limits or (vehicle.f_min, vehicle.f_max)
    f = np.where(along > 0.0, high, low)
    for azimuth in vehicle.turning:
        best = (along[:, azimuth.components] @ azimuth.corners.T).argmax(axis=1)
        f[:, azimuth.components] = azimuth.corners[best]
    return f


def farthest(
    vehicle: Vehicle, along: FloatArray, limits: tuple[FloatArray, FloatArray] | None = None
) -> FloatArray:
    """Largest along'f (M,) within limits, as those of ``farthest_thrusts``."""
    most: FloatArray = (along * farthest_thrusts(vehicle, along, limits)).sum(axis=1)
    return most


def limit_rows(vehicle: Vehicle) -> HalfPlanes:
    """Limits of all thrusts as A f <= reach: f_max, -f_min, then sides of polygons."""
    eye, sides = np.eye(vehicle.n), vehicle.half_planes or HalfPlanes(np.zeros((0, vehicle.n)), np.zeros(0))
    reach = np.concatenate([vehicle.f_max, -vehicle.f_min, sides.reach])
    return HalfPlanes(np.vstack([eye, -eye, sides.A]), reach)


def vertices(vehicle: Vehicle) -> list[FloatArray]:
    """Corners (v, c) of each thruster's set of forces [N]: ends of limits, or those of a polygon."""
    ends, corners = np.stack([vehicle.f_min, vehicle.f_max]), {a.first: a.corners for a in vehicle.turning}
    return [corners.get(at[0], np.unique(ends[:, list(at)], axis=0)) for at in vehicle.actuators]


@dataclass(frozen=True, eq=False, kw_only=True)
class Facets:
    """The facets of an attainable set whatever the limits are: only which thrusters have a choice matters.

    Attributes
    ----------
    half : (M, k) unit normals in scaled wrench, one of each opposite pair
    outreach : (M, n) by how much each thruster's half width moves a facet outwards [1/N]
    tolerance : (M,) largest |c't| at which a unit direction t counts as parallel to the facet with normal c
    """

    half: FloatArray
    outreach: FloatArray
    tolerance: FloatArray


@lru_cache(maxsize=256)  # limits of one log leave a choice to few different sets of thrusters
def facets(vehicle: Vehicle, choosing: tuple[int, ...]) -> Facets:
    """The facets where exactly the thrusters ``choosing`` have f_min < f_max."""
    refuse_azimuths(vehicle.azimuths, "facets within limits of a call", "limits are polygons")
    scaled = vehicle.TP / vehicle.wrench_scale[:, None]
    columns = scaled[:, list(choosing)]
    U, sigma, _ = np.linalg.svd(columns)
    r = independent(sigma, max(sigma.max(initial=0.0), NOTHING))
    normals = _normals(U[:, :r].T @ columns) @ U[:, :r].T
    across = U[:, r:].T
    outreach = np.zeros((len(normals) + len(across), vehicle.n))
    outreach[: len(normals), list(choosing)] = np.abs(normals @ columns)
    tolerance = np.repeat([NOTHING, RANK_TOLERANCE], [len(normals), len(across)])
    return Facets(half=np.vstack([normals, across]), outreach=outreach, tolerance=tolerance)


def _normals(generators: FloatArray) -> FloatArray:
    """(M, r) distinct unit normals of the (r - 1)-subsets of generators (r, m); one of each +- pair.

    Generators that nearly depend on each other span a thin facet, whose normal is known to rounding over its
    thinness only. That is good enough: every normal makes a true inequality, and this one is at right angles
    to its generators up to rounding. Leaving the facet out would cost its thinness.
    """
    r = len(generators)
    if r == 0:
        return np.zeros((0, 0))
    lengths = np.linalg.norm(generators, axis=0)
    # A thruster that is nearly off and pushes where the set counts as flat has length 0 in the r dimensions.
    unit = generators[:, lengths > 0] / lengths[lengths > 0]
    chosen = list(combinations(range(unit.shape[1]), r - 1))
    subsets = np.array(chosen, dtype=np.intp).reshape(len(chosen), r - 1)
    _, sigma, Vt = np.linalg.svd(unit.T[subsets])
    proper = sigma[:, -1] > FLAT if r > 1 else np.ones(len(subsets), dtype=bool)
    normals = Vt[proper, -1]
    leading = np.take_along_axis(normals, np.argmax(np.abs(normals) > NOTHING, axis=1)[:, None], axis=1)
    return _distinct(normals * np.sign(leading))


def _distinct(normals: FloatArray) -> FloatArray:
    """The rows (M, r) that are more than FLAT apart."""
    # Rows whose nine decimals differ are apart; the few that share them are compared with each other.
    _, first, inverse, counts = np.unique(
        normals.round(9), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    kept = [first[counts == 1]]
    order = np.argsort(inverse, kind="stable")
    ends = np.cumsum(counts)
    for i in np.flatnonzero(counts > 1):
        rows = order[ends[i] - counts[i] : ends[i]]
        while rows.size:
            kept.append(rows[:1])
            rows = rows[np.abs(normals[rows] - normals[rows[0]]).max(axis=1) > FLAT]
    distinct: FloatArray = normals[np.concatenate(kept)]
    return distinct
