"""The thrust that commands make, drawn: an ESC's curve at each voltage, its dead band, and the limits."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from alloc import Vehicle
from alloc.vehicle.esc import Esc
from bench.report.pictures.style import BLUE, FAINT, GREY, INK, VERMILION


def thrust_curve(vehicle: Vehicle) -> Figure:
    """One panel for each ESC of the vehicle that differs from the others."""
    thrusters: dict[Esc, list[str]] = {}
    for i, esc in enumerate(vehicle.esc):
        thrusters.setdefault(esc, []).append(vehicle.called(i))
    figure = Figure((8.4, 3.2 * len(thrusters) + 0.6))
    panels = figure.subplots(len(thrusters), 1, squeeze=False)[:, 0]
    for axes, (esc, names) in zip(panels, thrusters.items(), strict=True):
        own = [i for i, other in enumerate(vehicle.esc) if other is esc]
        ends = float(vehicle.f_min[own].min()), float(vehicle.f_max[own].max())
        _panel(axes, esc, ends)
        if len(thrusters) > 1:
            axes.set_title(", ".join(names), loc="left")
    figure.suptitle(f"{vehicle.name}: thrust of a command", x=0.01, ha="left", fontsize=10)
    return figure


def _panel(axes: Axes, esc: Esc, ends: tuple[float, float]) -> None:
    u = 2 * esc.neutral - esc.command if esc.reversed else esc.command
    # The voltage that calls take where they name none stands out.
    chosen = esc.nominal if np.isfinite(esc.nominal) else esc.volts[0]
    for volts, f in zip(esc.volts, esc.curve, strict=True):
        nominal = volts == chosen or len(esc.volts) == 1
        axes.plot(u, f, color=BLUE if nominal else GREY, linewidth=1.6 if nominal else 0.8)
        if np.isfinite(volts):
            axes.annotate(f"{volts:g} V", (u[-1], f[-1]), color=INK, fontsize=7)
    still = u[(esc.at(np.array([chosen]))[0] == 0)]
    dead = still.size > 0 and still.min() < still.max()  # else the curve is zero at neutral alone
    if dead:
        axes.axvspan(float(still.min()), float(still.max()), facecolor=FAINT)
    for end in ends:
        axes.axhline(end, color=VERMILION, linestyle="--", linewidth=0.8)
    axes.axhline(0.0, color=INK, linewidth=0.5)
    shaded = "; shaded: the dead band" if dead else ""
    axes.set_xlabel(f"command, {esc.low:g} to {esc.high:g} by {esc.step:g}{shaded}")
    axes.set_ylabel("thrust [N]; dashed: limits")
