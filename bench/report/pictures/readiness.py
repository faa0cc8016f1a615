"""Picture of how ready each thruster was, over a log."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from alloc.allocation import BoolArray, FloatArray
from bench.report.pictures.style import BLUE, FAINT, INK, VERMILION, shorten

TITLE = "readiness over time"
COLUMNS = 4


def readiness(
    names: Sequence[str],
    windows: Sequence[tuple[float, float]],
    p: FloatArray,
    half_width: FloatArray,
    accused: BoolArray,
    healthy: float,
) -> Figure:
    """Estimates by window with their intervals, a panel a thruster; accused ones in another colour.

    Parameters
    ----------
    names : of the n thrusters
    windows : begin and end of each of W [s]
    p, half_width : (W, n) estimates and half of their intervals [-], NaN where nothing can be said
    accused : (W, n) True where a thruster is accused
    healthy : least readiness that accuses nobody, drawn as a band
    """
    columns = min(COLUMNS, len(names))
    rows = -(-len(names) // columns)
    figure = Figure((2.1 * columns, 1.0 + 1.5 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for axes, name, *of_thruster in zip(panels, names, p.T, half_width.T, accused.T, strict=False):
        axes.axhspan(healthy, 2 - healthy, color=FAINT, linewidth=0)
        axes.axhline(1.0, color=INK, linewidth=0.5)
        for span, middle, half, is_weak in zip(windows, *of_thruster, strict=True):
            colour = VERMILION if is_weak else BLUE
            axes.fill_between(span, middle - half, middle + half, color=colour, alpha=0.3, linewidth=0)
            axes.plot(span, [middle, middle], color=colour)
        axes.set_title(shorten(name, 18), fontsize=9)
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    panels[0].set_ylim(min(0.0, 1.1 * float(np.nanmin(p))), None)
    figure.supxlabel("time [s]", fontsize=9)
    figure.supylabel("readiness: 1 as expected, 0 off", fontsize=9)
    return figure
