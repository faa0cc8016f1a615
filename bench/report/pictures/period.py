"""The share of a control period that a call takes, at three rates."""

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator

from bench.report.pictures.style import BLUE, GREEN, INK, PAPER, VERMILION, brief, headed
from bench.results.ranking import best, telling
from bench.results.rows import Run

RATES_HZ = {50: (GREEN, "o"), 100: (BLUE, "s"), 400: (VERMILION, "^")}
"""Colour and mark of each control rate."""

MOST = 12
"""Most methods in one picture."""


def draw(run: Run, vehicle: str) -> Figure | None:
    """p99 over the period as a mark for each rate; 100 % is a missed deadline.

    p99 is of the single calls on all of the vehicle's demand sets. Where there are too few calls for it, a
    hollow mark shows the slowest call.
    """
    shown: list[tuple[str, float, bool]] = []
    every = best(run, vehicle, run.sets(vehicle)[0])
    for row in telling(every, MOST):
        singles = run.singles(row)
        tail = run.tail_us(row, 0.99)
        if singles:
            shown.append((row.label, singles[-1][0] if tail is None else 1000 * tail, tail is not None))
    if not shown:
        return None
    shown.sort(key=lambda item: -item[1])
    figure = Figure((7.5, 1.6 + 0.2 * len(shown)))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    for y, (_, ns, known) in enumerate(shown):
        for rate, (paint, mark) in RATES_HZ.items():
            inside = paint if known else PAPER
            axes.plot([ns * 1e-9 * rate * 100], [y], mark, color=paint, markerfacecolor=inside, markersize=5)
    axes.axvline(100, color=INK, linewidth=1)
    axes.xaxis.set_major_locator(LogLocator(numticks=20))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{share:g} %"))
    axes.set_yticks(range(len(shown)), [brief(label) for label, _, _ in shown])
    axes.set_ylim(-0.7, len(shown) - 0.3)
    axes.set_xlabel("p99 of a call (hollow: slowest of too few), share of the control period")
    axes.set_title(headed(f"{vehicle}, all demand sets", len(shown), len(every)))
    marks = [Line2D([], [], color=c, marker=m, linestyle="") for c, m in RATES_HZ.values()]
    figure.legend(marks, [f"{rate} Hz" for rate in RATES_HZ], loc="outside lower center", ncols=3)
    return figure
