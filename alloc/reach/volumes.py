"""Volume that the thrusters reach, and volume that a closed form reaches.

Volumes are those of sets of tau / row_lengths, so all axes count in newtons. A failure leaves T, and
with it the unit, as it is, so the ratio of two volumes of one vehicle does not depend on the units of
its axes. A set that has extent in r < k directions only is measured in those r, [N^r].
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from math import comb, factorial

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.errors import NotApplicable, SolverError
from alloc.reach.zonotope import candidates, farthest, limit_rows, zonotope
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.degeneracy import NOTHING


def attainable_volume(vehicle: Vehicle) -> float:
    """Volume of {T P f : f_min <= f <= f_max}, exactly [N^r].

    A zonotope is tiled by the parallelepipeds of its generators: the sum over all r-subsets of
    |det| of the columns times the widths f_max - f_min (Shephard 1974, "Combinatorial properties of
    associated zonotopes"). Raises NotApplicable for more than TILES parallelepipeds. Where thrusters turn the
    set is no zonotope, and its volume that of the hull of its vertices.
    """
    return _hull(vehicle).volume if vehicle.azimuths else float(_tiles(vehicle).volumes.sum())


def uniform_demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m] uniform over the attainable set, drawn without rejection.

    A tile is drawn with a probability proportional to its volume, a point in it uniformly. The tiles are
    the lower faces of a zonotope one dimension up, which lifts each generator by a random height
    (Billera & Sturmfels 1992, "Fiber polytopes"); so the heights say on which corner of the other
    generators' box a tile stands. Where thrusters turn, simplices from the set's middle to its surface stand
    for tiles. Raises NotApplicable where the set is a single point, or has more than TILES.
    """
    if vehicle.azimuths:
        hull = _hull(vehicle)
        chosen = rng.choice(len(hull.volumes), size=n, p=hull.volumes / hull.volumes.sum())
        places = rng.dirichlet(np.ones(hull.corners.shape[1]), n)
        drawn: FloatArray = np.einsum("ij,ijk->ik", places, hull.corners[chosen])
        return drawn
    tiles = _tiles(vehicle)
    if not tiles.volumes.size:
        raise NotApplicable(
            f"{vehicle.name}: the limits leave each thruster one thrust, and the set one wrench"
        )
    r, m = tiles.coordinates.shape
    heights = rng.normal(size=(m,))
    weights = np.ones((len(tiles.members), m))
    for row, members in enumerate(tiles.members):
        slope = np.linalg.solve(tiles.coordinates[:, members].T, heights[members])
        weights[row] = np.sign(slope @ tiles.coordinates - heights)
    chosen = rng.choice(len(tiles.volumes), size=n, p=tiles.volumes / tiles.volumes.sum())
    shares = weights[chosen]
    np.put_along_axis(shares, tiles.members[chosen], rng.uniform(-1.0, 1.0, (n, r)), axis=1)
    z = zonotope(vehicle)
    taus: FloatArray = z.center + shares @ z.generators.T
    return taus


def closed_form_volume(vehicle: Vehicle) -> float:
    """Volume of {tau : f_min <= T* tau <= f_max}, tau = T P f: what eq. 8 serves inside the limits [N^r].

    The vertices of that polytope come from Qhull, the volume from their hull. It is 0 where no demand fits.
    Raises SolverError where Qhull gives up, as on a polytope that is nearly flat.
    """
    scaled = vehicle.TP / vehicle.row_lengths[:, None]
    basis = np.linalg.svd(scaled)[0][:, : vehicle.rank]
    rows = (generalized_inverse(vehicle) * vehicle.row_lengths) @ basis  # f = rows y, tau = scale basis y
    limits = limit_rows(vehicle)
    A = limits.A @ rows
    moved = np.linalg.norm(A, axis=1) > RANK_TOLERANCE * np.linalg.norm(rows)
    if (limits.reach[~moved] < 0).any():
        return 0.0
    volume = _polytope(vehicle.name, A[moved], limits.reach[moved] / vehicle.f_scale).volume
    return float(volume * vehicle.f_scale ** A.shape[1])


def safe_share(vehicle: Vehicle) -> float:
    """Largest s <= 1 for which the closed form (eq. 8) meets s tau inside the limits for all attainable tau.

    It puts the paper's premise for eq. 6, demands so small that limits never act, into a number. By the
    support of the attainable set along each row a'T*, s is the minimum over their limits a'f <= r of
    r / max_f a'T* T P f. It is 0 where the limits exclude f = 0.
    """
    rows = limit_rows(vehicle)
    reach = farthest(vehicle, rows.A @ generalized_inverse(vehicle) @ vehicle.TP)
    asked = np.abs(reach) > RANK_TOLERANCE * vehicle.f_scale
    share = float((rows.reach[asked] / reach[asked]).min(initial=1.0))
    return 0.0 if (rows.reach < 0).any() else max(share, 0.0)


def worst_fault(vehicle: Vehicle, keep_rank: bool = False) -> int:
    """Index of the working thruster whose loss leaves the lowest rank, and among those the least volume.

    ``keep_rank`` leaves out thrusters whose loss costs rank, if there are others. Raises NotApplicable
    where only one thruster works, or the vehicle that is left has more than TILES.
    """
    if len(vehicle.ready) < 2:
        raise NotApplicable(f"{vehicle.name}: one thruster works; with none left there is no vehicle")
    left = {i: vehicle.with_fault(i) for i in vehicle.ready}
    if keep_rank and any(v.rank == vehicle.rank for v in left.values()):
        left = {i: v for i, v in left.items() if v.rank == vehicle.rank}
    volumes = {i: attainable_volume(v) for i, v in left.items()}
    # Volumes that differ by rounding only, as symmetric thrusters leave, count as equal: the first wins.
    largest = max(volumes.values()) or 1.0
    return min(left, key=lambda i: (left[i].rank, round(volumes[i] / largest, 9)))


TILES = 50_000
"""Most tiles that are enumerated, within a second: 20 thrusters in 6 DOF have 38,760."""


@dataclass(frozen=True, eq=False)
class _Tiles:
    """The parallelepipeds of a zonotope, flat ones left out.

    Attributes
    ----------
    coordinates : (r, m) the generators in an orthonormal basis [N]
    members : (M, r) indices of the generators that span each tile
    volumes : (M,) volume of each tile [N^r]
    """

    coordinates: FloatArray
    members: IndexArray
    volumes: FloatArray


def _tiles(vehicle: Vehicle) -> _Tiles:
    z = zonotope(vehicle)
    columns = z.generators / vehicle.row_lengths[:, None]
    r, m = z.dimension, columns.shape[1]
    if comb(m, r) > TILES:
        raise NotApplicable(
            f"{vehicle.name}: {m} thrusters in {r} dimensions make {comb(m, r)} tiles; volumes are worked "
            f"out from at most {TILES}"
        )
    if r == 0:
        return _Tiles(np.zeros((0, m)), np.zeros((0, 0), dtype=np.intp), np.zeros(0))
    basis = np.linalg.svd(columns, full_matrices=False)[0][:, :r]
    coordinates = basis.T @ columns
    members = np.array(list(combinations(range(m), r)), dtype=np.intp)
    volumes = 2.0**r * np.abs(np.linalg.det(coordinates[:, members].transpose(1, 0, 2)))
    full = volumes > RANK_TOLERANCE * volumes.max()
    return _Tiles(coordinates, members[full], volumes[full])


@dataclass(frozen=True, eq=False)
class _Simplices:
    """A polytope in simplices that meet in its middle.

    Attributes
    ----------
    corners : (M, r + 1, r) of each simplex
    volumes : (M,) of each
    volume : of the polytope, by Qhull; where that merges facets, the sum over simplices was 3e-5 off
    """

    corners: FloatArray
    volumes: FloatArray
    volume: float


def _polytope(name: str, A: FloatArray, b: FloatArray) -> _Simplices:
    """The polytope A y <= b in simplices, none where it is flat or empty; vertices and surface are Qhull's.

    Raises SolverError where Qhull gives up, as on a polytope that is nearly flat.
    """
    from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

    r = A.shape[1]
    inside, clearance = _center(A, b)
    if clearance <= RANK_TOLERANCE:
        return _Simplices(np.zeros((0, r + 1, r)), np.zeros(0), 0.0)
    if r == 1:
        ends = b / A[:, 0]
        vertices = np.array([ends[A[:, 0] < 0].max(), ends[A[:, 0] > 0].min()])[:, None]
        surface: IndexArray = np.arange(2)[:, None]
        volume = float(vertices[1, 0] - vertices[0, 0])
    else:
        try:
            vertices = HalfspaceIntersection(np.column_stack([A, -b]), inside).intersections
            try:
                hull = ConvexHull(vertices)
            except QhullError:  # vertices that coincide but for rounding; Q14 merges their facets
                hull = ConvexHull(vertices, qhull_options="Qt Qx Q14")
            surface, volume = np.asarray(hull.simplices, dtype=np.intp), float(hull.volume)
        except QhullError as error:
            raise SolverError(f"{name}: Qhull on a polytope: {str(error).splitlines()[0]}") from None
    middle = np.broadcast_to(inside, (len(surface), 1, r))
    corners = np.concatenate([middle, vertices[surface]], axis=1)
    volumes = np.abs(np.linalg.det(corners[:, 1:] - middle)) / factorial(r)
    return _Simplices(corners, volumes, volume)


@lru_cache(maxsize=16)
def _hull(vehicle: Vehicle) -> _Simplices:
    """The attainable set of thrusters that turn: corners (M, r + 1, k) [N, N m], volumes (M,) [N^r]."""
    if (count := candidates(vehicle)) > TILES:
        raise NotApplicable(
            f"{vehicle.name}: sides of polygons span up to {count} facets; volumes are worked out from"
            f" at most {TILES}"
        )
    z = zonotope(vehicle)
    basis = np.linalg.svd(z.generators / z.scale[:, None], full_matrices=False)[0][:, : z.dimension]
    proper = z.tolerance <= NOTHING  # the others span what no thruster pushes
    found = _polytope(vehicle.name, z.facets[proper] @ basis, z.support[proper])
    if not found.volumes.size:
        raise NotApplicable(f"{vehicle.name}: the limits leave one wrench")
    middle = z.center / z.scale
    beside = middle - basis @ (basis.T @ middle)
    return _Simplices(
        (found.corners @ basis.T + beside) * z.scale,
        found.volumes * vehicle.f_scale**z.dimension,
        found.volume * vehicle.f_scale**z.dimension,
    )


def _center(A: FloatArray, b: FloatArray) -> tuple[FloatArray, float]:
    """The point farthest inside A y <= b, and its distance to the nearest plane."""
    from scipy.optimize import linprog

    r = A.shape[1]
    lengths = np.linalg.norm(A, axis=1)
    optimum = linprog(
        np.append(np.zeros(r), -1.0),
        A_ub=np.column_stack([A, lengths]),
        b_ub=b,
        bounds=[(None, None)] * (r + 1),
        method="highs",
    )
    if optimum.x is None:
        return np.zeros(r), -1.0
    return optimum.x[:-1], float(optimum.x[-1])
