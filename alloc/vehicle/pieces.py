"""Sets of forces that are not convex, as convex pieces; a choice of one piece a thruster is a combination."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import product
from math import acos, ceil, cos, degrees, prod, radians
from typing import TYPE_CHECKING

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from alloc.vehicle.azimuth import Azimuth, polygon_corners

if TYPE_CHECKING:
    from alloc.vehicle.model import Vehicle

MOST_COMBINATIONS = 256
"""Most combinations of pieces; each is a problem of its own in every call, of 10 to 100 us."""
CLIPPED = 1e-3
"""Least angle by which the end of an arc cuts a ring's piece [deg]; a smaller cut leaves a corner out."""

Arc = tuple[float, float]


def sector_pieces(most: float, arc: Arc, sides: int) -> list[FloatArray]:
    """Polygons (v, 2) of a disc or sector [N]: one, or over 180 degrees first and last half disc."""
    low, high = arc
    if 180.0 < high - low < 360.0:
        return [polygon_corners(most, half, sides) for half in ((low, low + 180.0), (high - 180.0, high))]
    return [polygon_corners(most, arc, sides)]


def largest_least(most: float, sides: int) -> float:
    """Force [N] below which the least force of a ring must stay, so that pieces cover its outer edge."""
    return most * (2.0 * cos(radians(180.0 / sides)) - 1.0)


def ring_pieces(least: float, most: float, arc: Arc, sides: int) -> list[FloatArray]:
    """Polygons (v, 2) that stand for forces from ``least`` to ``most`` in an arc [N].

    Each is what a tangent of the inner circle cuts off the disc, within the arc. There are as many, evenly
    spread, as it takes for the inner edge to lose no more newtons between tangents than the outer edge does
    between corners: half an angle between them of acos(least / (least + most (1 - cos(180 deg / sides)))).
    """
    start, end = arc
    lost = most * (1.0 - cos(radians(180.0 / sides)))
    half = degrees(acos(least / (least + lost)))
    count = ceil((end - start) / (2.0 * half) - 1e-9)
    wide, whole = degrees(acos(least / most)), end - start >= 360.0
    pieces = []
    for j in range(count):
        middle = start + (j + 0.5) * (end - start) / count
        if whole:
            middle = j * 360.0 / count
        low, high = middle - wide, middle + wide
        cut = [not whole and start > low + CLIPPED, not whole and end < high - CLIPPED]
        if not whole:
            low, high = max(low, start), min(high, end)
        steps = max(2 if not any(cut) else 1, ceil((high - low) * sides / 360.0 - 1e-9))
        outer = [(most, angle) for angle in np.linspace(low, high, steps + 1).tolist()]
        inner = [
            (least / cos(radians(angle - middle)), angle)
            for angle, clipped in ((high, cut[1]), (low, cut[0]))
            if clipped
        ]
        radius, angles = np.array(outer + inner).T
        pieces.append(
            np.column_stack([radius * np.cos(np.radians(angles)), radius * np.sin(np.radians(angles))])
        )
    return pieces


def join(
    first: int,
    pieces: Sequence[FloatArray],
    sector: Arc | None,
    place: str,
    rate_deg: float | None = None,
    slew: float | None = None,
) -> Azimuth:
    """The thruster whose forces are those of any of the pieces, and angles those of a sector [deg]."""
    several = (tuple(pieces), sector) if len(pieces) > 1 else ((), None)
    return Azimuth(first, np.vstack(pieces), place, *several, rate_deg, slew)


def check_combinations(azimuths: Sequence[Azimuth]) -> None:
    """Raise VehicleError where there are more combinations than are tried."""
    counts = [len(azimuth.parts) for azimuth in azimuths]
    if (count := prod(counts)) > MOST_COMBINATIONS:
        each = " x ".join(map(str, counts))
        raise VehicleError(
            f"thrusters: {each} = {count} combinations of convex pieces, and {MOST_COMBINATIONS} are tried at"
            " most; give min nearer to 0, fewer sides or fewer zones",
            "thrusters",
        )


@lru_cache(maxsize=64)
def combinations(vehicle: "Vehicle") -> "tuple[Vehicle, ...]":
    """The vehicle with one piece for each thruster that turns and works, all choices; itself if it has one.

    What it can do is the union of what these can do.
    """
    from dataclasses import replace

    if not any(azimuth.pieces for azimuth in vehicle.azimuths):
        return (vehicle,)
    choices = [
        azimuth.parts if vehicle.readiness[azimuth.first] else azimuth.parts[:1]
        for azimuth in vehicle.azimuths
    ]
    return tuple(replace(vehicle, azimuths=chosen) for chosen in product(*choices))
