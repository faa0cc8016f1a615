"""The table of a probe as a picture, for paper: one thruster a line, with boxes to tick."""

import textwrap
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from alloc import Vehicle
from alloc.lint.probe import Probe
from alloc.vehicle.frame import described
from bench.report.pictures.style import FAINT, GREY, INK

COLUMNS = (0.0, 0.22, 0.32, 0.66, 0.94)
"""Left edges of the columns: thruster, thrust, words, numbers, boxes."""
WIDTHS = (22, 10, 44, 34)
"""Letters of a line in each column but the last."""


def sheet(vehicle: Vehicle, found: Sequence[Probe]) -> Figure:
    """The figure, to be made and saved within the settings of ``style``."""
    rows = [(p.thruster, f"{p.thrust:+.3g} N", p.words, p.numbers) for p in found]
    cells = [
        [textwrap.wrap(text, width) or [""] for text, width in zip(row, WIDTHS, strict=True)] for row in rows
    ]
    heights = [max(map(len, row)) + 0.7 for row in cells]
    total = 4.5 + sum(heights)
    figure = Figure(figsize=(9, 0.19 * total))
    figure.set_layout_engine("none")  # everything has its place below
    axes = figure.add_axes((0.04, 0.02, 0.93, 0.96))
    axes.axis("off")
    axes.set_xlim(0, 1)
    axes.set_ylim(total, 0)
    axes.text(0, 0.6, f"{vehicle.name}: each thruster alone, a tenth of its thrust", fontsize=11, va="center")
    axes.text(0, 1.9, f"frame {described(vehicle.frame)}", fontsize=8, color=GREY, va="center")
    header = ("thruster", "thrust", "what it should do", "in its frame", "yes")
    for x, text in zip(COLUMNS, header, strict=True):
        axes.text(x, 3.4, text, fontsize=8, color=GREY, va="center")
    y = 4.2
    for row, height in zip(cells, heights, strict=True):
        axes.plot([0, 1], [y, y], color=FAINT, linewidth=0.8)
        for x, lines in zip(COLUMNS, row, strict=False):
            axes.text(x, y + 0.35, "\n".join(lines), fontsize=8.5, color=INK, va="top", linespacing=1.25)
        box = Rectangle((COLUMNS[-1], y + 0.35), 0.018, 0.8, fill=False, edgecolor=INK, linewidth=1)
        axes.add_patch(box)
        y += height
    return figure
