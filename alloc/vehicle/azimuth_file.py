"""Azimuth thrusters of a vehicle file: checked, and written as two fixed thrusters each."""

from collections.abc import Iterator, Sequence
from functools import partial
from math import inf

import numpy as np
from msgspec.structs import replace

from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from alloc.vehicle.azimuth import Azimuth, near_ahead
from alloc.vehicle.keys import MISSING, AzimuthKeys, Numbers, Rates, Thruster, VehicleFile
from alloc.vehicle.pieces import Arc, check_combinations, join, largest_least, ring_pieces, sector_pieces

MOST_SIDES = 64
"""Most sides of a polygon: it then loses 0.12 % of the radius."""
TURN = 6.3
"""Angles that all lie within this are taken for radians [deg]: a turn is 6.28 of them."""
UNSUPPORTED = (
    *("planar", "T", "H", "volts", "esc", "cap", "autopilot", "reaction_torque", "names", "suspect"),
    *("groups", "inertia"),
)
"""Keys that a file with azimuth thrusters can't have yet."""


def expand(keys: VehicleFile) -> tuple[VehicleFile, tuple[Azimuth, ...]]:
    """The keys with each azimuth thruster as two fixed ones along x and y, and the azimuths.

    The keys themselves, and none, where no thruster turns. Raises VehicleError for an azimuth that is none,
    for too many combinations of convex pieces, and for a key that does not go with azimuths yet.
    """
    thrusters = keys.thrusters or []
    if not any(thruster.azimuth for thruster in thrusters):
        return keys, ()
    check_directions(thrusters, turning=True)
    if isinstance(keys.slew, (Rates, list)):
        raise VehicleError("slew: give one number [N/s] for the fixed thrusters beside azimuths", "slew")
    if keys.slew is not None and all(thruster.azimuth for thruster in thrusters):
        raise VehicleError("slew: no fixed thruster is there to have it; give it in 'azimuth'", "slew")
    for key in UNSUPPORTED:
        if getattr(keys, key) not in (None, []):
            raise VehicleError(f"{key}: not supported yet beside azimuth thrusters; leave it out", key)
    fixed = sum(thruster.azimuth is None for thruster in thrusters)
    low, high = (_limits(keys, key, fixed) for key in ("f_min", "f_max"))
    weights = _weights(keys.weights, len(thrusters))
    made: list[Thruster] = []
    azimuths: list[Azimuth] = []
    f_min, f_max, prices = list[float](), list[float](), list[float]()
    for i, (thruster, weight) in enumerate(zip(thrusters, weights, strict=True)):
        if thruster.azimuth is None:
            made.append(replace(thruster, name=""))
            f_min.append(next(low))
            f_max.append(next(high))
            prices.append(weight)
            continue
        key = f"thrusters[{i}]"
        if any(thruster.direction):
            raise VehicleError(f"{key}: has direction and azimuth; keep one of them", key)
        pieces, sector = read_pieces(thruster.azimuth, f"{key}.azimuth")
        rates = thruster.azimuth.rate_deg, thruster.azimuth.slew
        azimuths.append(join(len(made), pieces, sector, f"{key}.azimuth", *rates))
        corners = azimuths[-1].corners
        made += [Thruster(thruster.position, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))]
        f_min += corners.min(axis=0).tolist()
        f_max += corners.max(axis=0).tolist()
        prices += [weight, weight]
    check_combinations(azimuths)
    return replace(keys, thrusters=made, f_min=f_min, f_max=f_max, weights=prices), tuple(azimuths)


def check_directions(thrusters: Sequence[Thruster], *, turning: bool = False) -> None:
    """Raise VehicleError where a direction is missing or no unit vector, or of one ``turning`` unasked."""
    for i, thruster in enumerate(thrusters):
        key = f"thrusters[{i}]"
        if thruster.azimuth is not None:
            if not turning:
                raise VehicleError(
                    f"{key}: has azimuth, which is not supported here yet; take a vehicle of fixed thrusters",
                    key,
                )
        elif thruster.direction is MISSING:
            raise VehicleError(f"{key}: key 'direction' is missing; give a unit vector, or 'azimuth'", key)
    directions = np.array([(1.0, 0.0, 0.0) if t.azimuth else t.direction for t in thrusters])
    lengths = np.linalg.norm(directions, axis=1)
    i = int(np.argmax(np.abs(lengths - 1)))
    if abs(lengths[i] - 1) > 1e-3:  # published unit vectors carry three digits or more
        key = f"thrusters[{i}].direction"
        unit_vector = directions[i] / lengths[i] if 0 < lengths[i] < np.inf else np.eye(3)[0]
        entries = ", ".join(f"{entry:.4g}" for entry in unit_vector)
        raise VehicleError(f"{key} has length {lengths[i]:.4g}; give a unit vector, as [{entries}]", key)


def read_pieces(keys: AzimuthKeys, place: str) -> tuple[list[FloatArray], Arc | None]:
    """Convex polygons (v, 2) that ``keys`` describe [N], and the sector that they fill [deg].

    The sector is None for a whole turn, and where zones interrupt it. Raises VehicleError, with the place.
    """

    def refused(key: str, why: str) -> VehicleError:
        return VehicleError(f"{place}.{key}: {why}", f"{place}.{key}")

    if not 0.0 < keys.max < inf:
        raise refused("max", f"is {keys.max:g}; give the largest force, above 0 [N]")
    if not 0.0 <= keys.min <= keys.max:
        raise refused("min", f"is {keys.min:g}; give 0, or a force up to max = {keys.max:g} [N]")
    if not 3 <= keys.sides <= MOST_SIDES:
        raise refused("sides", f"is {keys.sides}; give 3 to {MOST_SIDES} sides of the polygon in the disc")
    start, end = keys.sector_deg
    if not -720.0 <= start < end <= 720.0:
        raise refused("sector_deg", f"is {[start, end]}; give [from, to] in degrees, from below to")
    if max(abs(start), abs(end)) < TURN:
        raise refused("sector_deg", f"{[start, end]} look like radians; give degrees")
    if end - start > 360.0:
        raise refused("sector_deg", f"spans {end - start:g} degrees; give at most 360")
    for key, unit in (("rate_deg", "deg/s"), ("slew", "N/s")):
        if (rate := getattr(keys, key)) is not None and not 0.0 < rate < inf:
            raise refused(key, f"is {rate:g}; give a rate above 0 [{unit}], or leave it out")
    for zone in keys.forbidden_deg:
        low, high = zone
        if not -720.0 <= low < high <= 720.0 or high - low > 360.0:
            raise refused("forbidden_deg", f"has {[low, high]}; give [from, to] in degrees, from below to")
        if max(abs(low), abs(high)) < TURN and not (low.is_integer() and high.is_integer()):
            raise refused("forbidden_deg", f"{[low, high]} look like radians; give degrees")
    left = free_arcs((start, end), keys.forbidden_deg)
    if not left:
        raise refused("forbidden_deg", "leaves nothing of the sector; give smaller zones")
    if keys.min >= (below := max(largest_least(keys.max, keys.sides), 0.0)) and keys.min > 0.0:
        why = (
            f"is {keys.min:g}; a ring of {keys.sides} sides up to {keys.max:g} N needs less than {below:.4g}"
        )
        raise refused("min", f"{why}: give a smaller one, or more sides")
    split = partial(ring_pieces, keys.min) if keys.min > 0.0 else sector_pieces
    pieces = [piece for arc in left for piece in split(keys.max, arc, keys.sides)]
    low, high = left[0]
    return pieces, None if len(left) > 1 or high - low >= 360.0 else near_ahead(low, high)


def free_arcs(sector: Arc, forbidden: Sequence[Arc]) -> list[Arc]:
    """Arcs of a sector that no zone forbids, in order [deg]; arcs that meet at the end of a turn are one."""
    start, end = sector
    cuts = sorted(
        (max(low + turn, start), min(high + turn, end))
        for low, high in forbidden
        for turn in range(-1440, 1441, 360)
        if low + turn < end and high + turn > start
    )
    arcs, at = list[Arc](), start
    for low, high in cuts:
        if low > at:
            arcs.append((at, low))
        at = max(at, high)
    if at < end:
        arcs.append((at, end))
    if end - start == 360.0 and cuts and len(arcs) > 1 and arcs[0][0] == start and arcs[-1][1] == end:
        arcs = [(arcs[-1][0] - 360.0, arcs[0][1]), *arcs[1:-1]]
    return arcs


def _limits(keys: VehicleFile, key: str, fixed: int) -> Iterator[float]:
    """A limit of each fixed thruster [N]."""
    limit = getattr(keys, key)
    if not fixed and limit is not None:
        raise VehicleError(f"{key}: no fixed thruster is there to have it; leave it out", key)
    if fixed and limit is None:
        raise VehicleError(f"{key}: missing; give [N] of the fixed thrusters", key)
    values: Numbers = limit if isinstance(limit, list) else [limit or 0.0] * fixed
    if len(values) != fixed:
        raise VehicleError(f"{key}: {len(values)} numbers for {fixed} fixed thrusters; give one each", key)
    return iter(values)


def _weights(weights: Numbers | None, thrusters: int) -> Numbers:
    """A weight of each thruster [1/N^2]."""
    if weights is not None and len(weights) != thrusters:
        raise VehicleError(
            f"weights: {len(weights)} numbers for {thrusters} thrusters; give one each", "weights"
        )
    return weights or [1.0] * thrusters
