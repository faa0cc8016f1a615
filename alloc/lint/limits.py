"""The remarks on limits: one-sided, uneven or assumed ones, another unit than newtons, what moves them."""

from collections.abc import Iterator

import numpy as np

from alloc.allocation import FloatArray
from alloc.lint.report import FARTHEST_ARM, Remark, note, warning
from alloc.reach.attainable import single_axis_maxima
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import Azimuth
from alloc.vehicle.geometry import MOMENTS
from alloc.vehicle.keys import VehicleFile

SHORTEST_ARM = 2e-3  # m; where no arm is longer, they are probably written in km or the vehicle is a toy
LONG_ARM, WEAK = 5.0, 200.0  # m, N; a vehicle ten metres long has stronger thrusters
NORMALISED = 1.0
"""Largest limit [N] that looks like a share of full throttle, or like kilonewtons: the weakest thrusters sold
for underwater vehicles give some 5 N."""
LOPSIDED = 10.0
"""Largest thrust one way over the other: a T200 gives four fifths astern, and no propeller gives a tenth."""
FAST = 200.0
"""Rate of control [Hz] that few vehicles exceed."""
NOTHING = 1e-9
"""Share of ``wrench_scale`` up to which what limits leave of an axis is rounding [-]."""
ANGLES = 1440
"""Angles of a turn at which the least force is asked for: a quarter of a degree apart."""
ROUNDED = 0.99
"""Share of f_max that a curve must reach; closer figures differ as tables of three digits do [-]."""
STRONGEST = 1e7  # N; ten times the thrust of a large ship's bow thruster, so probably mN


def on_limits(vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on limits that are one-sided, uneven, equal or look assumed."""
    low, high = vehicle.f_min, vehicle.f_max
    for i in np.flatnonzero((low > 0) | (high < 0)):
        yield warning(
            "f_min" if low[i] > 0 else "f_max",
            f"{vehicle.called(int(i))} can't stop: 0 N is outside its limits; is a minus missing?",
        )
    yield from _on_lost_ways(vehicle)
    for i in np.flatnonzero(low == high):
        name = vehicle.called(int(i))
        yield warning("f_max", f"{name} has f_min = f_max = {low[i]:g} N; it can't be commanded")
    one_way = np.flatnonzero(((low == 0) | (high == 0)) & (low != high))
    if one_way.size:
        yield note("f_min", f"{one_way.size} of {vehicle.n} thrusters push one way only")
    uneven = np.flatnonzero((low < 0) & (high > 0) & (low != -high))
    if uneven.size:
        first = int(uneven[0])
        span = f"{low[first]:g} … {high[first]:g} N"
        yield note("f_max", f"not the same ahead and astern ({span}): mind which way each one points")
    for i in np.flatnonzero(
        (low < 0) & (high > 0) & (np.maximum(-low, high) > LOPSIDED * np.minimum(-low, high))
    ):
        yield warning(
            "f_max", f"{vehicle.called(int(i))} has limits of {low[i]:g} … {high[i]:g} N; is one mistyped?"
        )
    sizes = np.concatenate([np.abs(low), np.abs(high)])
    if len(set(sizes[sizes > 0])) == 1 and _round(sizes.max()):
        yield note("f_max", f"{sizes.max():g} N for every thruster is a round number; measured, or assumed?")


def on_polygons(vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on the set of each thruster that turns, with what its polygons lose of disc or sector."""
    for i, (first, *second) in enumerate(vehicle.actuators):
        if not second:
            continue
        azimuth = next(one for one in vehicle.azimuths if one.first == first)
        most = float(np.linalg.norm(azimuth.corners, axis=1).max())
        forces = least_forces(azimuth)
        span = "a disc" if len(forces) == ANGLES else "what zones leave of a disc"
        if azimuth.sector:
            span = "a sector from {:.4g} to {:.4g} degrees".format(*azimuth.sector)
        arcs = [part.reach[part.reach > 0.0] for part in azimuth.parts]
        lost = 100 * (1 - min(float(arc.min()) for arc in arcs) / most)
        said = f"the {len(arcs[0])} sides of the polygon lose {lost:.2g} % at worst"
        if azimuth.pieces:
            said = f"the sides of its {len(arcs)} convex pieces lose {lost:.2g} % at worst"
        least = max(-float(part.reach.min()) for part in azimuth.parts)
        more = ""
        if least > 0.0:
            more = f", and at least {least:.4g} N, at some angles {forces.max():.4g} N"
        yield note(
            f"thrusters[{i}]", f"{vehicle.called(i)} gives up to {most:g} N in {span}{more}; of it {said}"
        )


def least_forces(azimuth: Azimuth) -> FloatArray:
    """Least force at each of ANGLES angles of a turn that any of the convex pieces has [N]."""
    angles = np.linspace(0.0, 2.0 * np.pi, ANGLES, endpoint=False)
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    least = np.full(ANGLES, np.inf)
    for part in azimuth.parts:
        along = rays @ part.normals.T
        outside = ((along == 0.0) & (part.reach < 0.0)).any(axis=1)
        ends = part.reach / np.where(along == 0.0, np.inf, along)
        near = np.where(along < 0.0, ends, 0.0).max(axis=1)
        far = np.where(outside, -np.inf, np.where(along > 0.0, ends, np.inf).min(axis=1))
        least = np.where(near <= far, np.minimum(least, near), least)
    found: FloatArray = least[np.isfinite(least)]
    return found


def _on_lost_ways(vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on axes that T pushes and limits leave nothing of, alone and at least one way."""
    if (vehicle.f_min > 0).any() or (vehicle.f_max < 0).any():
        return
    astern, ahead = single_axis_maxima(vehicle)
    least = NOTHING * vehicle.wrench_scale
    pushed = vehicle.TP.any(axis=1)
    nothing = np.stack([pushed & (ahead <= least), pushed & (-astern <= least)], axis=1)
    lost = [f"{'+-'[way]}{vehicle.dof[axis]}" for axis, way in np.argwhere(nothing)]
    if lost:
        yield warning(
            "f_min",
            f"no thrust within the limits gives {', '.join(lost)} alone: thrusters that push one way only"
            " need others against them",
        )


def on_units(vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on limits and arms that can't be newtons and metres, with the factor that they are off by."""
    if vehicle.f_scale <= NORMALISED:
        yield warning(
            "f_max",
            f"no thruster gives more than {vehicle.f_scale:g} N: a share of full throttle, as PX4 has it, or"
            " kN? multiply f_min and f_max by full thrust in N (kN: by 1000)",
        )
    if vehicle.f_scale > STRONGEST:
        yield warning("f_max", f"{vehicle.f_scale:g} N is more than any thruster gives; mN? divide by 1000")
    rows = [row for axis, row in zip(vehicle.dof, vehicle.T, strict=True) if axis in MOMENTS]
    arms = np.abs(rows)
    if not arms.size or not arms.any():
        return
    if arms.max() > FARTHEST_ARM:
        yield warning("T", f"an arm is {arms.max():g} m long; mm? divide the moment rows by 1000")
    elif arms.max() > LONG_ARM and vehicle.f_scale < WEAK:
        yield warning(
            "T",
            f"an arm is {arms.max():.3g} m long, and no thruster gives more than {vehicle.f_scale:.3g} N; cm?"
            " divide positions and center_of_mass, or the moment rows, by 100",
        )
    if arms.max() < SHORTEST_ARM:
        yield warning("T", f"the longest arm is {arms.max():g} m; km? multiply the moment rows by 1000")


def on_moving_limits(keys: VehicleFile, vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on what the lowest voltage leaves, and on how long full thrust takes by the slew rates."""
    whence = "esc" if keys.volts is None else "volts"
    if (table := vehicle.by_volts) is not None:
        lowest = float(table.volts[0])
        low, high = vehicle.limits(volts=lowest)
        weakest = int(np.argmin(high - low))
        if (high - low)[weakest] < (vehicle.f_max - vehicle.f_min)[weakest]:
            yield note(
                whence,
                f"at {lowest:g} V {vehicle.called(weakest)} gives {low[weakest]:g} … {high[weakest]:g} N"
                f" of {vehicle.f_min[weakest]:g} … {vehicle.f_max[weakest]:g} N",
            )
        own = (vehicle.f_min <= 0) & (vehicle.f_max >= 0)
        for row, at in enumerate(table.volts):
            low, high = table.f_min[row], table.f_max[row]
            for i in np.flatnonzero(own & ((low > 0) | (high < 0)))[:1]:
                outside = f"0 N is outside {low[i]:g} … {high[i]:g} N"
                called = vehicle.called(int(i))
                yield warning(whence, f"at {at:g} V {called} can't stop: {outside}; is a minus missing?")
        short = np.flatnonzero(table.f_max.max(axis=0) < ROUNDED * vehicle.f_max)
        if short.size:
            i = int(short[0])
            others = f" (and {short.size - 1} more)" if short.size > 1 else ""
            yield warning(
                "f_max",
                f"{vehicle.called(i)} gives {table.f_max[:, i].max():g} N at most by '{whence}', less"
                f" than f_max = {vehicle.f_max[i]:g} N{others}",
            )
    if vehicle.slew is not None:
        slowest = float((vehicle.f_max / vehicle.slew.up).max())
        yield note("slew", f"from 0 N to f_max the slowest thruster takes {slowest:.2g} s")
        yield from _on_steps(vehicle, np.minimum(vehicle.slew.up, vehicle.slew.down))


def _on_steps(vehicle: Vehicle, slew: FloatArray) -> Iterator[Remark]:
    """A remark where steps of an ESC are coarser than ``slew`` (n,) [N/s] allows between two usual calls."""
    if not vehicle.esc:
        return
    steps = np.array([esc.largest_step for esc in vehicle.esc])
    rates = slew / steps
    i = int(rates.argmin())
    if rates[i] < FAST:
        yield warning(
            "slew",
            f"above {rates[i]:.3g} Hz {vehicle.called(i)} may change by less between two calls than a step of"
            f" its ESC makes, {steps[i]:.2g} N: give 'f_previous' what was allocated; with what was made,"
            " thrusts may stand still",
        )


def _round(value: float) -> bool:
    # Round numbers have one digit and zeros, as 40, 200 or 1.
    return float(f"{value:.0e}") == value
