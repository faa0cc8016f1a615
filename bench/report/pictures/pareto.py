"""Error against time: what each method loses of the wrench, and the Pareto front."""

from matplotlib.figure import Figure

from alloc.allocation import WRENCH_TOLERANCE
from bench.report.pictures.labels import label_points
from bench.report.pictures.style import FAINT, colour, headed, legend, share_axis, time_axis
from bench.results.ranking import best, front, largest_loss, telling
from bench.results.rows import Run

FLOOR = WRENCH_TOLERANCE
"""A wrench missed by less counts as met and is drawn at this height, because a log axis has no zero."""
MOST = 12
"""Most methods in one picture."""


def draw(run: Run, vehicle: str) -> Figure | None:
    """Worst share of the wrench lost over median time; the line joins the Pareto front."""
    demands = run.sets(vehicle)[0]
    every = best(run, vehicle, demands)
    points = [
        (time, max(error, FLOOR), row)
        for row in telling(every, MOST)
        if (time := row.call_p50_us) and (error := largest_loss(row)) is not None
    ]
    if not points:
        return None
    figure = Figure((7.5, 5))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    kept = front([(time, error) for time, error, _ in points])
    axes.step(*zip(*kept, strict=True), where="post", color=FAINT, linewidth=4, zorder=1)
    for time, error, row in points:
        axes.plot([time], [error], "o", color=colour(row), markersize=5)
    time_axis(axes.xaxis, "one call, median")
    share_axis(axes.yaxis, "largest share of a demand's wrench that is lost", floor=FLOOR)
    axes.set_title(headed(f"{vehicle}, {demands} demands", len(points), len(every)))
    legend(figure, [row for *_, row in points])
    on_front = set(kept)
    # Points of the front come first, so their labels get the best places.
    ordered = sorted(points, key=lambda point: point[:2] not in on_front)
    named = [(time, error, row.method) for time, error, row in ordered]
    label_points(axes, named)
    return figure
