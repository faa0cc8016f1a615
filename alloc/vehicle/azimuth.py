"""Thrusters that turn: polygons of the forces that they give, and refusals of what takes no polygon."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, ceil, degrees, floor, hypot, nan
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import NotApplicable, VehicleError

NEARLY = 1e-12
"""Share of the largest force that counts as zero in a corner or in the reach of a side."""


NOTHING = 1e-6
"""Share of the largest limit up to which a force has no angle: a solver that iterates leaves as much [-]."""
SPARE = 8 * float(np.finfo(np.float64).eps)
"""Share of the largest limit by which thrusts are moved further in than a side asks [-]."""


class HalfPlanes(NamedTuple):
    """Limits of thrusters that turn: A f <= reach.

    Attributes
    ----------
    A : (q, n) rows of unit length, none of a thruster that is off [-]
    reach : (q,) negative where zero force is left out [N]
    """

    A: FloatArray
    reach: FloatArray


@dataclass(frozen=True, eq=False)
class Azimuth:
    """A thruster that turns, as the convex polygon of forces that it can give, or as several.

    Attributes
    ----------
    first : index of its force along x in f; the next one is along y
    corners : (v, 2) corners of the polygon, turning from x to y [N]; of several, those of all
    place : file, line and key that it is from; empty for one that is from no file
    pieces : corners of each of several polygons; empty for one
    arc : angles from … to of the forces of several polygons [deg]; None for a whole turn, and where zones
        interrupt it
    rate_deg, slew : how fast it turns [deg/s], and how fast the size of its force may change [N/s]; None
        where nothing says
    """

    first: int
    corners: FloatArray
    place: str = ""
    pieces: tuple[FloatArray, ...] = ()
    arc: tuple[float, float] | None = None
    rate_deg: float | None = None
    slew: float | None = None

    @cached_property
    def parts(self) -> tuple["Azimuth", ...]:
        """The same with one polygon, for each; itself where it has one."""
        return tuple(Azimuth(self.first, one, self.place) for one in self.pieces) or (self,)

    @cached_property
    def normals(self) -> FloatArray:
        """(v, 2) outward unit normals of the sides, the first from corner 0 to corner 1 [-].

        Raises NotApplicable for several polygons, and so does all that follows from sides.
        """
        refuse_pieces([self], "what is asked for")
        along = np.roll(self.corners, -1, axis=0) - self.corners
        across = np.column_stack([along[:, 1], -along[:, 0]])
        normals: FloatArray = across / np.linalg.norm(across, axis=1, keepdims=True)
        return normals

    @cached_property
    def along(self) -> tuple[FloatArray, FloatArray]:
        """(v, 2) unit vectors along the sides [-], and (v,) how far along each its first corner is [N]."""
        units = self.normals @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        return units, (self.corners * units).sum(axis=1)

    @cached_property
    def lengths(self) -> FloatArray:
        """(v,) lengths of the sides [N]."""
        far: FloatArray = np.linalg.norm(np.roll(self.corners, -1, axis=0) - self.corners, axis=1)
        return far

    @cached_property
    def reach(self) -> FloatArray:
        """(v,) distance of each side from zero force [N]."""
        far = (self.normals * self.corners).sum(axis=1)
        return np.where(np.abs(far) <= NEARLY * np.abs(self.corners).max(), 0.0, far)

    @cached_property
    def middle(self) -> FloatArray:
        """(2,) mean of the corners [N]."""
        mean: FloatArray = self.corners.mean(axis=0)
        return mean

    @cached_property
    def depth(self) -> FloatArray:
        """(v,) distance of the ``middle`` from each side [N]."""
        return self.reach - self.normals @ self.middle

    @cached_property
    def distinct(self) -> list[int]:
        """Indices of the sides, of two that are parallel the first."""
        sines = np.abs(self.normals @ [[0.0, -1.0], [1.0, 0.0]] @ self.normals.T)
        return [i for i in range(len(sines)) if not (sines[i, :i] <= NEARLY).any()]

    @cached_property
    def sector(self) -> tuple[float, float] | None:
        """Angles from … to of its forces, the first in -180 … 180 [deg]; None where they are a whole turn."""
        if self.pieces:
            return self.arc
        if (self.reach > 0.0).all():
            return None
        far = np.linalg.norm(self.corners, axis=1)
        x, y = self.corners[far > NEARLY * far.max()].T
        middle = degrees(atan2(self.middle[1], self.middle[0]))
        apart = (np.degrees(np.arctan2(y, x)) - middle + 180.0) % 360.0 - 180.0  # below half a turn
        low, high = (round(middle + float(end), 9) for end in (apart.min(), apart.max()))
        return near_ahead(low, high)

    @cached_property
    def rest_angle(self) -> float:
        """Angle of the ``sector`` nearest to 0, -180 … 180: that of no force [deg]."""
        if self.pieces:
            return min((part.rest_angle for part in self.parts), key=abs)
        low, high = self.sector or (0.0, 0.0)
        return 0.0 if low <= 0.0 <= high else min(low, high - 360.0 * (high > 180.0), key=abs)

    @property
    def components(self) -> list[int]:
        """Indices of its two forces in f."""
        return [self.first, self.first + 1]


def near_ahead(low: float, high: float) -> tuple[float, float]:
    """The same angles from … to, by whole turns so that the first is in -180 … 180 [deg]."""
    turns = 360.0 * floor((low + 180.0) / 360.0)
    return low - turns, high - turns


def polygon_corners(most: float, sector_deg: tuple[float, float], sides: int) -> FloatArray:
    """Corners (v, 2) of the polygon in a disc, or in a sector of up to 180 degrees, from x to y [N].

    A side spans 360 / ``sides`` degrees of the arc, or a little less, so the polygon loses 1 - cos(180 deg /
    ``sides``) of the radius at most. A disc has a corner straight ahead.
    """
    start, end = sector_deg
    span = end - start
    if span >= 360.0:
        angles = np.arange(sides) * 360.0 / sides
    else:
        angles = np.linspace(start, end, max(1, ceil(span * sides / 360.0 - 1e-9)) + 1)
    circle = np.column_stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))])
    corners = most * np.where(np.abs(circle) <= NEARLY, 0.0, circle)
    return corners if span >= 180.0 else np.vstack([np.zeros((1, 2)), corners])


def fit_polygons(azimuths: Sequence[Azimuth], F: FloatArray, spare: float) -> FloatArray:
    """Thrusts (N, n) [N], those outside of a polygon moved towards its middle, until ``spare`` inside."""
    inside = F.copy()
    for azimuth in azimuths:
        f = inside[:, azimuth.first : azimuth.first + 2]  # a view
        beyond = f @ azimuth.normals.T - azimuth.reach
        if beyond.max(initial=0.0) <= 0.0:  # the usual case, quickly
            continue
        share = np.where(beyond > 0.0, (beyond + spare) / (np.maximum(beyond, 0.0) + azimuth.depth), 0.0)
        f += np.minimum(share.max(axis=1), 1.0)[:, None] * (azimuth.middle - f)
    return inside


def nearest_thrusts(
    azimuths: Sequence[Azimuth], F: FloatArray, f_min: FloatArray, f_max: FloatArray
) -> FloatArray:
    """Thrusts (N, n) within limits that are nearest to F (N, n), thruster by thruster [N].

    A fixed thruster's is cut at its limit, (n,) or (N, n); of one that turns the force goes straight to its
    polygon, or to the nearest of several. Where f_min exceeds f_max, f_max counts.
    """
    nearest = np.clip(F, f_min, f_max)
    for azimuth in azimuths:
        f = F[:, azimuth.first : azimuth.first + 2]
        found, *others = [_nearest(part, f) for part in azimuth.parts]
        for other in others:
            nearer = ((other - f) ** 2).sum(axis=1) < ((found - f) ** 2).sum(axis=1)
            found = np.where(nearer[:, None], other, found)
        nearest[:, azimuth.first : azimuth.first + 2] = found
    return nearest


def _nearest(azimuth: Azimuth, f: FloatArray) -> FloatArray:
    """Forces (N, 2) of the polygon that are nearest to f (N, 2) [N]."""
    beyond = f @ azimuth.normals.T - azimuth.reach
    if beyond.max(initial=0.0) <= 0.0:  # the usual case, quickly
        return f
    # Outside, some side that the force is beyond has the nearest point, at its foot or at an end.
    along, start = azimuth.along
    feet = np.minimum(np.maximum(f @ along.T - start, 0.0), azimuth.lengths)
    # Of all sides the nearest has the least of what is beyond it and what is past its ends.
    past = f @ along.T - start - feet
    first = np.where(beyond > 0.0, np.hypot(beyond, past), np.inf).argmin(axis=1)
    rows = np.arange(len(f))
    found: FloatArray = azimuth.corners[first] + feet[rows, first][:, None] * along[first]
    return np.where(beyond.max(axis=1, keepdims=True) > 0.0, found, f)


def rest_thrusts(azimuths: Sequence[Azimuth], f0: FloatArray, inset: float) -> FloatArray:
    """Thrusts (n,) f0 [N] with forces within polygons that leave out zero force.

    Each is the polygon's nearest to zero, by a share ``inset`` of the way on towards its middle.
    """
    f = f0.copy()
    for azimuth in azimuths:
        if not (azimuth.reach >= 0.0).all():
            foot = _nearest(azimuth, np.zeros((1, 2)))[0]
            f[azimuth.components] = foot + inset * (azimuth.middle - foot)
    return f


def excess(
    azimuths: Sequence[Azimuth], F: FloatArray, f_min: FloatArray, f_max: FloatArray, rounding: float
) -> FloatArray:
    """Distance of thrusts (N, n) beyond each thruster's limits (N, n), negative inside [N].

    Both components of a thruster that turns have the distance of its force, of several polygons the least.
    Limits are (n,) or (N, n); ``rounding`` is what products may leave beyond a side of a polygon [N].
    """
    beyond: FloatArray = np.maximum(F - f_max, f_min - F)
    for azimuth in azimuths:
        f = F[:, azimuth.components]
        each = [(f @ part.normals.T - part.reach).max(axis=1, keepdims=True) for part in azimuth.parts]
        beyond[:, azimuth.components] = np.minimum.reduce(each) - rounding
    return beyond


def check_azimuths(
    name: str, azimuths: Sequence[Azimuth], readiness: FloatArray, others: Sequence[object]
) -> None:
    """Raise VehicleError where azimuths share components, or polygons are not convex.

    ``others`` are the vehicle's parts that do not go with azimuths yet, None for those that it has not.
    """
    if any(part is not None for part in others):
        raise VehicleError(f"{name}: azimuths have no voltages, ESCs, caps or autopilots yet")
    n, taken = len(readiness), list[int]()
    for azimuth in azimuths:
        x, y = azimuth.components
        if not 0 <= x < y < n or {x, y} & {*taken} or readiness[x] != readiness[y]:
            raise VehicleError(f"{name}: azimuths need two components of f each, as ready as one another")
        taken += [x, y]
        for part in azimuth.parts:
            _check_corners(name, part.corners)


def _check_corners(name: str, corners: FloatArray) -> None:
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3 or not np.isfinite(corners).all():
        raise VehicleError(f"{name}: an azimuth's corners are three or more pairs of finite numbers [N]")
    along = np.roll(corners, -1, axis=0) - corners
    after = np.roll(along, -1, axis=0)
    turning = along[:, 0] * after[:, 1] - along[:, 1] * after[:, 0]
    turns = np.arctan2(turning, (along * after).sum(axis=1)).sum() / (2.0 * np.pi)
    if not (turning > 0.0).all() or not turns < 1.5:  # a star turns more than once
        raise VehicleError(f"{name}: an azimuth's polygon is not convex, from x to y")


def half_planes(azimuths: Sequence[Azimuth], n: int) -> HalfPlanes | None:
    """Limits of thrusters that turn, as rows; None where there is none."""
    rows = np.zeros((sum(len(azimuth.reach) for azimuth in azimuths), n))
    end = 0
    for azimuth in azimuths:
        end += len(azimuth.reach)
        rows[end - len(azimuth.reach) : end, azimuth.components] = azimuth.normals
    return HalfPlanes(rows, np.concatenate([a.reach for a in azimuths])) if azimuths else None


def actuators(azimuths: Sequence[Azimuth], n: int) -> tuple[tuple[int, ...], ...]:
    """Indices of the components of f (n,) of each thruster: one, or two of one that turns."""
    turning = {azimuth.first for azimuth in azimuths}
    seconds = {first + 1 for first in turning}
    return tuple((i, i + 1) if i in turning else (i,) for i in range(n) if i not in seconds)


def polar(
    azimuths: Sequence[Azimuth], parts: Sequence[Sequence[int]], f: Sequence[float], largest: float
) -> tuple[list[float], list[float], list[float]]:
    """Force (m,) [N], angle and middle of the sector (m,) [deg] of each thruster, of thrusts (n,) [N].

    ``parts`` are the components of each. Of one that turns the angle lies in -180 … 180, from x towards y. A
    force up to NOTHING of the ``largest`` [N] is none, and its angle the ``rest_angle``. Of a fixed one angle
    and middle are NaN, of a disc the middle.
    """
    forces, angles, middles = list[float](), list[float](), list[float]()
    turning = {azimuth.first: azimuth for azimuth in azimuths}
    for first, *second in parts:
        x, y = f[first] + 0.0, f[second[0]] + 0.0 if second else 0.0
        force = hypot(x, y)
        nothing = force <= NOTHING * largest
        low, high = (turning[first].sector if second else None) or (nan, nan)
        forces.append(x if not second else 0.0 if nothing else force)
        angles.append(nan if not second else turning[first].rest_angle if nothing else degrees(atan2(y, x)))
        middles.append((low + high) / 2.0)
    return forces, angles, middles


def refuse_azimuths(azimuths: Sequence[Azimuth], what: str, reason: str) -> None:
    """Raise NotApplicable, with a place, where there are thrusters that turn and ``what`` takes none yet."""
    if azimuths:
        place = f"{azimuths[0].place}: " if azimuths[0].place else ""
        raise NotApplicable(f"{place}{what} takes no azimuth thrusters yet: {reason}; see docs/azimuth.md")


def refuse_pieces(azimuths: Sequence[Azimuth], what: str) -> None:
    """Raise NotApplicable, with a place, where a set of forces has several convex pieces."""
    for azimuth in azimuths:
        if azimuth.pieces:
            place = f"{azimuth.place}: " if azimuth.place else ""
            raise NotApplicable(
                f"{place}{len(azimuth.pieces)} convex pieces, and {what} takes sets of one piece alone; see"
                " docs/azimuth.md"
            )


def bounding_box(azimuths: Sequence[Azimuth], f_min: FloatArray, f_max: FloatArray) -> None:
    """Write the smallest box around each polygon into limits (n,) [N]."""
    for azimuth in azimuths:
        f_min[azimuth.components] = azimuth.corners.min(axis=0)
        f_max[azimuth.components] = azimuth.corners.max(axis=0)
