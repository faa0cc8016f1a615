"""Tail curves: the share of calls that took longer than a time, 1 - F, both axes logarithmic."""

from itertools import product
from typing import TYPE_CHECKING

from bench.report.pictures.style import FAMILIES, share_axis, time_axis
from bench.results.quantiles import Histogram, total
from bench.results.ranking import best
from bench.results.rows import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = 12
"""Most curves in one picture, those of the fastest methods: six colours, solid and dashed."""


def draw(run: Run, vehicle: str) -> "Figure | None":
    """One curve for each of the fastest methods, labelled at the right."""
    from matplotlib.figure import Figure

    demands = run.sets(vehicle)[0]
    rows = [row for row in best(run, vehicle, demands) if row.singles][:SHOWN]
    if not rows:
        return None
    figure = Figure((7.5, 4.6))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    looks = product(("solid", (0, (4, 1.5))), FAMILIES.values())
    for row, (dashes, colour) in zip(rows, looks, strict=False):
        times, share = slower(row.singles)
        axes.step(times, share, where="post", color=colour, linestyle=dashes, linewidth=1.3, label=row.label)
    time_axis(axes.xaxis, "one call")
    share_axis(axes.yaxis, "calls that took longer")
    axes.set_title(f"{vehicle}, {demands} demands, single calls")
    figure.legend(loc="outside right upper", title="by median")
    return figure


def slower(counted: Histogram) -> tuple[list[float], list[float]]:
    """Times [us] and the share of calls slower than each of them, down to one call."""
    n = total(counted)
    times, share, left = [], [], n
    for ns, count in counted:
        left -= count
        if left:
            times.append(ns / 1000)
            share.append(left / n)
    return times, share
