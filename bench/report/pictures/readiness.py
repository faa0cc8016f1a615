"""Picture of how ready each thruster was, over a log."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from alloc import Vehicle
from bench.judging.readiness import MODEL, VAGUE, WindowReadiness
from bench.report.pictures.style import BLUE, FAINT, INK, VERMILION, shorten

TITLE = "readiness over time"
COLUMNS = 4


def readiness(vehicle: Vehicle, windows: Sequence[WindowReadiness]) -> Figure:
    """Estimates by window, a panel a thruster, with their intervals; accused ones in another colour.

    A window that says nothing of a thruster is left empty.
    """
    columns = min(COLUMNS, vehicle.n)
    rows = -(-vehicle.n // columns)
    figure = Figure((2.1 * columns, 1.0 + 1.5 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for i, axes in enumerate(panels[: vehicle.n]):
        axes.axhspan(MODEL, 2 - MODEL, color=FAINT, linewidth=0)
        axes.axhline(1.0, color=INK, linewidth=0.5)
        for each in windows:
            if each.half_width[i] < VAGUE:
                colour = VERMILION if i in each.accused else BLUE
                axes.fill_between(
                    [each.begin, each.end],
                    each.p[i] - each.half_width[i],
                    each.p[i] + each.half_width[i],
                    color=colour,
                    alpha=0.3,
                    linewidth=0,
                )
                axes.plot([each.begin, each.end], [each.p[i]] * 2, color=colour)
        axes.set_title(shorten(vehicle.called(i), 18), fontsize=9)
    for axes in panels[vehicle.n :]:
        axes.set_axis_off()
    seen = [each.p[each.half_width < VAGUE] for each in windows]
    panels[0].set_ylim(min(0.0, 1.1 * float(np.concatenate(seen).min())), None)
    figure.supxlabel("time [s]", fontsize=9)
    figure.supylabel("readiness: 1 as expected, 0 off", fontsize=9)
    return figure
