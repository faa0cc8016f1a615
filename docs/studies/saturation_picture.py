"""Draws docs/saturation.svg: ``python docs/studies/saturation_picture.py docs/saturation.svg``.

The same demand on all axes of one vehicle grows from half of what the thrusters can do to three times that.
For each method the picture shows how much of it each axis gets.
"""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from alloc import Vehicle, alpha_max, build, load_vehicle
from alloc.allocation import FloatArray
from bench.judging.loss import delivered
from bench.report.pictures.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, SETTINGS, VERMILION, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VEHICLE = "bluerov2-heavy"
DEMAND = {"surge": 60.0, "sway": -25.0, "heave": 70.0, "roll": 4.0, "pitch": -3.0, "yaw": 12.0}
"""Ahead, to port and down while it turns and holds its attitude [N, N m]; the picture scales it."""
METHODS = (
    "clip",
    "shrink",
    "redistribute",
    "desaturate",
    "nullspace",
    "scaled",
    "scaled-by-group",
    "priority",
)
COLOURS = dict(zip(DEMAND, (BLUE, PURPLE, VERMILION, ORANGE, GREEN, GREY), strict=True))
WIDTHS = np.linspace(5.5, 1.0, len(DEMAND))
"""Lines that lie on each other stay visible."""
SIZES = np.linspace(0.5, 3.0, 251)
"""Demand over the edge of what the thrusters can do in its direction."""


def shares(method: str, vehicle: Vehicle) -> FloatArray:
    """(sizes, k) delivered on each axis over what is asked there; NaN where there is no answer [-]."""
    tau = np.array([DEMAND[axis] for axis in vehicle.dof])
    taus = np.outer(SIZES, tau * alpha_max(vehicle, [tau])[0])
    F, _ = build(method, vehicle).many(taus)
    return delivered(vehicle, F) / taus


def draw() -> "Figure":
    """The figure: a panel a method, a line an axis."""
    from matplotlib.figure import Figure

    vehicle = load_vehicle(VEHICLE)
    figure = Figure((9.0, 5.4))
    panels = figure.subplots(2, len(METHODS) // 2, sharex=True, sharey=True)
    for method, panel in zip(METHODS, panels.flat, strict=True):
        panel.axvline(1.0, color=INK, linewidth=0.8, linestyle=":")
        for axis, width, line in zip(vehicle.dof, WIDTHS, shares(method, vehicle).T, strict=True):
            panel.plot(SIZES, 100 * line, color=COLOURS[axis], linewidth=width, label=axis)
        panel.set_title(method)
        panel.set(xlim=(SIZES[0], SIZES[-1]), ylim=(-10, 135))
    figure.supxlabel("demand over the edge of what the thrusters can do", fontsize=9)
    figure.supylabel("delivered [% of what the axis asks]", fontsize=9)
    figure.legend(*panels.flat[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(DEMAND))
    return figure


def main() -> None:
    """Write the picture to the path given."""
    from matplotlib import rc_context

    with rc_context(SETTINGS):
        save(draw(), Path(sys.argv[1]))


if __name__ == "__main__":
    main()
