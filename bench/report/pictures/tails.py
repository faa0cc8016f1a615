"""Tail curves: the share of calls that took at least a time, both axes logarithmic."""

from matplotlib.figure import Figure

from bench.report.pictures.style import brief, headed, looks, share_axis, time_axis
from bench.results.quantiles import Histogram, total
from bench.results.ranking import best, telling
from bench.results.rows import Run

MOST = 10
"""Most curves in one picture."""


def draw(run: Run, vehicle: str) -> Figure | None:
    """A curve for each of the telling methods down to its slowest call, labelled at the right."""
    demands = run.sets(vehicle)[0]
    every = best(run, vehicle, demands)
    rows = telling([row for row in every if row.measured.singles], MOST)
    if not rows:
        return None
    figure = Figure((7.5, 4.6))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    styles = looks((row.label, row.family) for row in rows)
    for row in rows:
        times, share = at_least(row.measured.singles)
        colour, dashes = styles[row.label]
        axes.step(
            times, share, where="pre", color=colour, linestyle=dashes, linewidth=1.3, label=brief(row.label)
        )
        axes.plot(times[-1:], share[-1:], "o", color=colour, markersize=3.5)
    time_axis(axes.xaxis, "one call")
    share_axis(axes.yaxis, "calls that took at least so long (dot: the slowest)")
    axes.set_title(headed(f"{vehicle}, {demands} demands, single calls", len(rows), len(every)))
    figure.legend(loc="outside right upper", title="by median")
    return figure


def at_least(counted: Histogram) -> tuple[list[float], list[float]]:
    """Times [us] and the share of calls that took at least each: from all calls to the slowest."""
    n = left = total(counted)
    times, share = [], []
    for ns, count in counted:
        times.append(ns / 1000)
        share.append(left / n)
        left -= count
    return times, share
