"""Picture of a call's cost by method: median, p99.9 and the slowest call seen, on a log axis."""

from matplotlib.figure import Figure

from bench.report.pictures.style import brief, colour, headed, legend, time_axis
from bench.results.ranking import best, telling
from bench.results.rows import Run

MOST = 12
"""Most methods in one picture."""


def draw(run: Run, vehicle: str) -> Figure | None:
    """Median of each method as a dot, a thick whisker to p99.9, a thin one to the slowest call."""
    demands = run.sets(vehicle)[0]
    every = best(run, vehicle, demands)
    rows = telling(every, MOST)[::-1]
    if not rows:
        return None
    figure = Figure((7.5, 1.5 + 0.2 * len(rows)))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    for y, row in enumerate(rows):
        centre, singles, tail = row.call_p50_us or 0.0, run.singles(row), run.tail_us(row, 0.999)
        if singles:
            slowest = singles[-1][0] / 1000
            axes.plot([centre, slowest], [y, y], color=colour(row), linewidth=0.8)
            axes.plot([slowest], [y], "|", color=colour(row), markersize=6)
        if tail is not None:
            ends = [centre, max(centre, tail)]
            axes.plot(ends, [y, y], color=colour(row), linewidth=2.6, solid_capstyle="butt")
        axes.plot([centre], [y], "o", color=colour(row), markersize=5)
    time_axis(
        axes.xaxis,
        f"one call: median on {brief(demands)} demands (dot),"
        "\non all sets p99.9 (thick line) and slowest (bar)",
    )
    axes.set_yticks(range(len(rows)), [brief(row.label) for row in rows])
    axes.set_ylim(-0.7, len(rows) - 0.3)
    axes.grid(axis="y", visible=False)
    axes.set_title(headed(vehicle, len(rows), len(every)))
    legend(figure, rows)
    return figure
