"""How much of a control period the slowest call in a thousand takes, at three rates."""

from typing import TYPE_CHECKING

from bench import columns
from bench.plots.style import BLUE, GREEN, INK, VERMILION
from bench.ranking import best, number
from bench.rows import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RATES_HZ = {50: (GREEN, "o"), 100: (BLUE, "s"), 400: (VERMILION, "^")}
"""Colour and mark of each control rate."""


def draw(run: Run, vehicle: str) -> "Figure | None":
    """p99.9 over the period as a mark for each rate; 100 % is a missed deadline."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator

    demands = run.sets(vehicle)[0]
    timed = [(row, number(columns.call_p999_us(row))) for row in best(run, vehicle, demands)]
    rows = [(row, tail) for row, tail in timed if tail is not None][::-1]
    if not rows:
        return None
    figure = Figure((7.5, 1.5 + 0.2 * len(rows)))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    for rate, (paint, mark) in RATES_HZ.items():
        shares = [tail * 1e-6 * rate * 100 for _, tail in rows]
        axes.plot(shares, range(len(rows)), mark, color=paint, markersize=5, label=f"{rate} Hz")
    axes.axvline(100, color=INK, linewidth=1)
    axes.xaxis.set_major_locator(LogLocator(numticks=20))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{share:g} %"))
    axes.set_yticks(range(len(rows)), [row.label for row, _ in rows])
    axes.set_ylim(-0.7, len(rows) - 0.3)
    axes.set_xlabel("p99.9 of a call, share of the control period; the line is all of it")
    axes.set_title(f"{vehicle}, {demands} demands")
    figure.legend(loc="outside lower center", ncols=3)
    return figure
