"""Error against time: what each method loses of the wrench, and the Pareto front."""

from typing import TYPE_CHECKING

from alloc import Family
from bench.report.lost import largest
from bench.report.pictures.labels import label_points
from bench.report.pictures.style import FAINT, colour, legend, share_axis, time_axis
from bench.results.ranking import best
from bench.results.rows import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FLOOR = 1e-12
"""Errors below this are rounding and are drawn at this height, because a log axis has no zero."""

UNNAMED = (Family.SOFT, Family.ONE_SHOT)
"""Families whose points carry no name: they show each solver again, by another route."""


def draw(run: Run, vehicle: str) -> "Figure | None":
    """Worst share of the wrench lost over median time; the line joins the Pareto front."""
    from matplotlib.figure import Figure

    demands = run.sets(vehicle)[0]
    points = [
        (time, max(error, FLOOR), row)
        for row in best(run, vehicle, demands)
        if (time := row.call_p50_us) and (error := largest(row)) is not None
    ]
    if not points:
        return None
    figure = Figure((7.5, 5))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    front = pareto([(time, error) for time, error, _ in points])
    axes.step(*zip(*front, strict=True), where="post", color=FAINT, linewidth=4, zorder=1)
    for time, error, row in points:
        axes.plot([time], [error], "o", color=colour(row), markersize=5)
    time_axis(axes.xaxis, "one call, median")
    share_axis(axes.yaxis, "largest share of a demand's wrench that is lost")
    axes.set_title(f"{vehicle}, {demands} demands")
    legend(figure, [row for *_, row in points])
    on_front = set(front)
    # Points of the front come first, so their labels get the best places.
    ordered = sorted(points, key=lambda point: point[:2] not in on_front)
    named = [(time, error, "" if row.family in UNNAMED else row.method) for time, error, row in ordered]
    label_points(axes, named)
    return figure


def pareto(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points that no other point beats in both numbers, sorted by the first."""
    front: list[tuple[float, float]] = []
    for point in sorted(points):
        if not front or point[1] < front[-1][1]:
            front.append(point)
    return front
