"""Draws docs/limits.svg: ``python docs/studies/limits_picture.py docs/limits.svg``.

What a full and an empty battery, slew rates and a blocked thruster leave of the attainable set: a section in
surge and yaw, all other axes held at what the thrusts of that moment push.
"""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from alloc import Vehicle, alpha_max, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.limits import Interval
from bench.judging.capability import corners
from bench.report.pictures.style import BLUE, GREEN, GREY, INK, SETTINGS, VERMILION, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VEHICLE = "bluerov2-heavy"
MOMENT = {"surge": 60.0, "yaw": 8.0}
"""The demand that was just answered [N, N m]: ahead in a gentle turn."""
STEPS_S = (0.01, 0.05, 0.1)
"""Times to the next call: control rates of 100, 20 and 10 Hz."""
ANGLES = 720


def section(vehicle: Vehicle, limits: Interval, f: FloatArray) -> FloatArray:
    """Corners (m, 2) of what can be pushed on surge and yaw within limits, the other axes as thrusts f do.

    f lies inside the limits, so the set is seen from the wrench that it pushes.
    """
    i, j = vehicle.dof.index("surge"), vehicle.dof.index("yaw")
    angles = np.linspace(0.0, 2 * np.pi, ANGLES, endpoint=False)
    rays = np.zeros((ANGLES, vehicle.k))
    rays[:, i] = np.cos(angles) * vehicle.wrench_scale[i]
    rays[:, j] = np.sin(angles) * vehicle.wrench_scale[j]
    low, high = limits
    reach = alpha_max(vehicle, rays, low - f, high - f)
    here = vehicle.TP @ f
    return here[[i, j]] + corners(reach[:, None] * rays[:, [i, j]])


def draw() -> "Figure":
    """The figure: the sets of four batteries and a blocked thruster, and those of three control rates."""
    from matplotlib.figure import Figure

    vehicle = load_vehicle(VEHICLE)
    tau = np.array([MOMENT.get(axis, 0.0) for axis in vehicle.dof])
    rest, now = np.zeros(vehicle.n), build("nullspace", vehicle)(tau).f
    figure = Figure((9.0, 4.8))
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    sets = [
        (left, "20 V", vehicle.limits(volts=20), rest, INK, "solid"),
        (left, "16.8 V", vehicle.limits(volts=16.8), rest, BLUE, "solid"),
        (left, "13 V", vehicle.limits(volts=13), rest, VERMILION, "solid"),
        (left, "13 V, thruster 0 blocked", vehicle.limits(volts=13, blocked=[0]), rest, VERMILION, "dashed"),
        (right, "16.8 V", vehicle.limits(volts=16.8), rest, BLUE, "solid"),
    ]
    for dt, colour in zip(STEPS_S, (GREY, GREEN, INK), strict=True):
        limits = vehicle.limits(volts=16.8, f_previous=now, dt=dt)
        sets.append((right, f"in {dt:g} s from here", limits, now, colour, "solid"))
    for panel, name, limits, f, colour, dashes in sets:
        outline = section(vehicle, limits, f)
        closed = np.vstack([outline, outline[:1]])
        panel.plot(*closed.T, color=colour, linestyle=dashes, linewidth=1.5, label=name)
    right.plot(*tau[[vehicle.dof.index(axis) for axis in MOMENT]], marker="o", markersize=2, color=INK)
    left.set_title("what the battery leaves")
    right.set_title("what slew rates leave, at 16.8 V")
    for panel in (left, right):
        panel.set_xlabel("surge [N]")
        panel.grid(visible=True)
        panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    left.set_ylabel("yaw [N m]")
    return figure


def main() -> None:
    """Write the picture to the path given."""
    from matplotlib import rc_context

    with rc_context(SETTINGS):
        save(draw(), Path(sys.argv[1]))


if __name__ == "__main__":
    main()
