"""How much a vehicle can do: the volume of what its thrusters reach, and of what a closed form reaches.

Volumes are of sets of tau / row_lengths, so all axes count in newtons and a failure, which leaves
T as it is, leaves the unit as it is: shares of two volumes of one vehicle mean the same whatever
the axes. A set that has extent in r < k directions only is measured in those, [N^r].
"""

from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.errors import NotApplicable, SolverError
from alloc.reach.zonotope import zonotope
from alloc.vehicle import RANK_TOLERANCE, Vehicle


def attainable_volume(vehicle: Vehicle) -> float:
    """Volume of {T P f : f_min <= f <= f_max}, exactly [N^r].

    A zonotope is tiled by the parallelepipeds of its generators: the sum over all r-subsets of
    |det| of the columns times the widths f_max - f_min (Shephard 1974, "Combinatorial properties of
    associated zonotopes"). Raises NotApplicable beyond TILES of them.
    """
    return float(_tiles(vehicle).volumes.sum())


def uniform_demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m] uniform over the attainable set, none thrown away.

    A tile is drawn by its volume, a point in it uniformly. Which corner of the other generators'
    box a tile stands on follows from a random height for each generator: lifted by it, the lower
    faces of the zonotope one dimension up are the tiles (Billera & Sturmfels 1992, "Fiber
    polytopes"). Raises NotApplicable where the set is a single point, or has more than TILES.
    """
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

    The vertices of that polytope come from Qhull, the volume from their hull. 0 where no demand fits.
    Raises SolverError where Qhull gives up, as on a polytope that is nearly flat.
    """
    from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

    scaled = vehicle.TP / vehicle.row_lengths[:, None]
    basis = np.linalg.svd(scaled)[0][:, : vehicle.rank]
    rows = (generalized_inverse(vehicle) * vehicle.row_lengths) @ basis  # f = rows y, tau = scale basis y
    moved = np.linalg.norm(rows, axis=1) > RANK_TOLERANCE * np.linalg.norm(rows)
    rest = ~moved
    if (vehicle.f_min[rest] > 0).any() or (vehicle.f_max[rest] < 0).any():
        return 0.0
    A = np.vstack([rows[moved], -rows[moved]])
    b = np.concatenate([vehicle.f_max[moved], -vehicle.f_min[moved]]) / vehicle.f_scale
    inside, clearance = _center(A, b)
    if clearance <= RANK_TOLERANCE:
        return 0.0
    if A.shape[1] == 1:
        ends = b / A[:, 0]
        return float((ends[A[:, 0] > 0].min() - ends[A[:, 0] < 0].max()) * vehicle.f_scale)
    try:
        vertices = HalfspaceIntersection(np.column_stack([A, -b]), inside).intersections
        volume: float = ConvexHull(vertices).volume * vehicle.f_scale ** A.shape[1]
    except QhullError as error:
        raise SolverError(
            f"{vehicle.name}: Qhull on the closed form's polytope: {str(error).splitlines()[0]}"
        ) from None
    return volume


def safe_share(vehicle: Vehicle) -> float:
    """How small demands must be for limits never to act: the paper's premise for eq. 6, as a number.

    The largest s for which s tau is met by f = T* tau inside the limits whatever attainable tau is:
    by the support of the attainable set along each row of T*, min over thrusters of f_max_i over
    max_f (T* T P f)_i, and the same below. At most 1; 0 where the limits do not let f be 0.
    """
    M = generalized_inverse(vehicle) @ vehicle.TP
    ends = np.stack([M * vehicle.f_min, M * vehicle.f_max])
    share = 1.0
    for reach, limit in (
        (ends.max(axis=0).sum(axis=1), vehicle.f_max),
        (ends.min(axis=0).sum(axis=1), vehicle.f_min),
    ):
        asked = np.abs(reach) > RANK_TOLERANCE * vehicle.f_scale
        share = min(share, float((limit[asked] / reach[asked]).min(initial=1.0)))
    outside = (vehicle.f_min > 0).any() or (vehicle.f_max < 0).any()
    return 0.0 if outside else max(share, 0.0)


def worst_fault(vehicle: Vehicle, keep_rank: bool = False) -> int:
    """Index of the working thruster whose loss leaves least: the lowest rank, then the least volume.

    With ``keep_rank``, out of those whose loss costs no rank, if there are any. Raises NotApplicable
    where only one thruster works, or what is left has more than TILES.
    """
    if len(vehicle.working) < 2:
        raise NotApplicable(f"{vehicle.name}: one thruster works; with none left there is no vehicle")
    left = {int(i): vehicle.with_fault(int(i)) for i in vehicle.working}
    if keep_rank and any(v.rank == vehicle.rank for v in left.values()):
        left = {i: v for i, v in left.items() if v.rank == vehicle.rank}
    volumes = {i: attainable_volume(v) for i, v in left.items()}
    # Alike thrusters leave alike volumes up to rounding; of those the first is taken.
    largest = max(volumes.values()) or 1.0
    return min(left, key=lambda i: (left[i].rank, round(volumes[i] / largest, 9)))


TILES = 50_000
"""Most tiles that are looked at, within a second: 20 thrusters in 6 DOF have 38,760."""


@dataclass(frozen=True, eq=False)
class _Tiles:
    """The parallelepipeds of a zonotope, flat ones left out.

    coordinates (r, m): the generators in an orthonormal basis [N]. members (M, r): which span each
    tile. volumes (M,) [N^r].
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


def _center(A: FloatArray, b: FloatArray) -> tuple[FloatArray, float]:
    """The point farthest inside A y <= b, and its distance to the nearest plane."""
    from scipy.optimize import linprog

    r = A.shape[1]
    lengths = np.linalg.norm(A, axis=1)
    found = linprog(
        np.append(np.zeros(r), -1.0),
        A_ub=np.column_stack([A, lengths]),
        b_ub=b,
        bounds=[(None, None)] * (r + 1),
        method="highs",
    )
    if found.x is None:
        return np.zeros(r), -1.0
    return found.x[:-1], float(found.x[-1])
