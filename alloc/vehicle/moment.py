"""Sets of one call where thrusters turn: what rates leave around the last forces, as polygons within them."""

from collections.abc import Sequence
from math import acos, atan2, ceil, cos, degrees, hypot, inf, radians

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.azimuth import NEARLY, NOTHING, Azimuth, actuators
from alloc.vehicle.limits import Interval, Slew, of_a_moment, thrusts

QUARTER = 90.0
"""Most degrees that a force may turn from one call to the next."""
STEP = 11.25
"""Most degrees between corners of the outer edge around a last force."""


class Sets(tuple[FloatArray, FloatArray]):
    """f_min and f_max (n,) of a moment [N], and of each thruster that turns the polygons in these boxes.

    Attributes
    ----------
    polygons : of each of ``vehicle.azimuths`` the corners (v, 2) of its convex pieces [N]; none where nothing
        is left
    """

    polygons: tuple[tuple[FloatArray, ...], ...]

    @classmethod
    def from_polygons(cls, boxes: Interval, polygons: Sequence[Sequence[FloatArray]]) -> "Sets":
        """Sets within the boxes of fixed thrusters; those of others are written around their polygons."""
        made = cls(boxes)
        made.polygons = tuple(map(tuple, polygons))
        return made

    @property
    def empty(self) -> bool:
        """True where some thruster has no force left."""
        return bool((self[0] > self[1]).any())


def sets_of_a_moment(
    name: str,
    own: Interval,
    azimuths: Sequence[Azimuth],
    readiness: FloatArray,
    slew: Slew | None,
    f_previous: ArrayLike | None,
    dt: float | None,
    angles: ArrayLike | None,
) -> Sets:
    """The sets of each thruster: its own, or within them what rates leave around the last thrusts.

    Parameters and errors are those of ``Vehicle.limits``, of a vehicle with such parts.
    """
    rated = [azimuth.rate_deg is not None or azimuth.slew is not None for azimuth in azimuths]
    if slew is None:
        if f_previous is not None and dt is not None and not any(rated):
            raise VehicleError(f"{name}: has no rates; add 'rate_deg' or 'slew' to its file", "slew")
        slew = Slew(*np.full((2, len(own[0])), inf))
    low, high = of_a_moment(name, own, None, slew, None, f_previous, dt)
    polygons = [[part.corners for part in azimuth.parts] for azimuth in azimuths]
    if f_previous is None or dt is None:
        return Sets.from_polygons((low, high), polygons)
    last = thrusts(f_previous, len(low))
    parts, largest = actuators(azimuths, len(low)), float(np.abs(own).max())
    known = _checked_angles(angles, len(parts))
    for i, azimuth in enumerate(azimuths):
        if rated[i] and readiness[azimuth.first]:
            x, y = last[azimuth.components].tolist()
            angle = known[parts.index((azimuth.first, azimuth.first + 1))]
            if hypot(x, y) > NOTHING * largest:
                angle = degrees(atan2(y, x))
            elif np.isnan(angle):
                angle = azimuth.rest_angle
            wedge = reachable(azimuth, hypot(x, y), angle, dt)
            cuts = [] if wedge is None else [clip(wedge, part) for part in azimuth.parts]
            polygons[i] = [cut for cut in cuts if cut is not None]
        corners = np.vstack(polygons[i]) if polygons[i] else np.array([[inf, inf], [-inf, -inf]])
        both = [corners.min(axis=0), corners.max(axis=0)] if polygons[i] else corners
        off = not readiness[azimuth.first]
        low[azimuth.components], high[azimuth.components] = (0.0, 0.0) if off else both
    return Sets.from_polygons((low, high), polygons)


def _checked_angles(angles: ArrayLike | None, m: int) -> FloatArray:
    if angles is None:
        return np.full(m, np.nan)
    known = np.asarray(angles, dtype=np.float64)
    if known.shape != (m,) or np.isinf(known).any():
        raise DemandError(f"angles has shape {known.shape}; give ({m},), an angle or NaN a thruster [deg]")
    return known


def reachable(azimuth: Azimuth, size: float, angle: float, dt: float) -> FloatArray | None:
    """Convex polygon (v, 2) of what rates leave within dt [s] around a force of that size [N], angle [deg].

    It lies between the circles of the smallest and the largest size, whose inner one it meets at the last
    angle alone, and turns by no more than ``rate_deg`` allows, nor by more than QUARTER. None where the force
    can't come down to the thruster's most.
    """
    most = float(np.linalg.norm(azimuth.corners, axis=1).max())
    turn = QUARTER if azimuth.rate_deg is None else min(azimuth.rate_deg * dt, QUARTER)
    step = inf if azimuth.slew is None else azimuth.slew * dt
    low, high = max(size - step, 0.0), size + step
    if low > most:
        return None
    if high >= most:
        high = 2.0 * most  # the set's own sides are nearer
    whole = low <= 0.0 or low < high * cos(radians(turn))
    wide = turn if whole else degrees(acos(low / high))
    steps = 2 * max(1, ceil(wide / STEP - 1e-9))  # even, so that a corner is straight on
    radii, along = [high] * (steps + 1), np.linspace(angle - wide, angle + wide, steps + 1).tolist()
    if low > 0.0 and whole:
        radii += [low / cos(radians(turn))] * 2
        along += [angle + turn, angle - turn]
    elif low <= 0.0 and turn < QUARTER:
        radii.append(0.0)
        along.append(angle)
    turned = np.radians(along)
    return np.column_stack([np.array(radii) * np.cos(turned), np.array(radii) * np.sin(turned)])


def clip(corners: FloatArray, part: Azimuth) -> FloatArray | None:
    """Corners (v, 2) of a convex polygon within another one (Sutherland & Hodgman 1974); None for none."""
    size = float(np.abs(part.corners).max())
    for normal, far in zip(part.normals, part.reach, strict=True):
        beyond = corners @ normal - far
        if not (beyond < 0.0).any():
            return None
        if not (beyond > 0.0).any():
            continue
        kept = []
        for a, b, p, q in zip(
            corners, np.roll(corners, -1, axis=0), beyond, np.roll(beyond, -1), strict=True
        ):
            if p <= 0.0:
                kept.append(a)
            if (p < 0.0 < q) or (q < 0.0 < p):
                kept.append(a + p / (p - q) * (b - a))
        corners = np.array(kept)
    return _proper(corners, NEARLY * size)


def _proper(corners: FloatArray, near: float) -> FloatArray | None:
    """Corners of a convex polygon without those that rounding made; None where fewer than three are left."""
    points = list(corners)
    i = 0
    while len(points) >= 3 and i < len(points):
        a, b, c = points[i - 1], points[i], points[(i + 1) % len(points)]
        one, two = b - a, c - b
        turning = one[0] * two[1] - one[1] * two[0]
        if turning > near * max(np.hypot(*one), np.hypot(*two)) and np.hypot(*one) > near:
            i += 1
            continue
        del points[i]
        i = max(i - 1, 0)
    return np.array(points) if len(points) >= 3 else None
