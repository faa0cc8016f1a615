"""How time and memory of each method grow with the number of thrusters, both axes logarithmic."""

from itertools import product

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.report.pictures.style import FAMILIES, time_axis
from bench.results.growth import series
from bench.results.rows import Run


def draw_run(run: Run) -> Figure | None:
    """Median call above, allocator size below; a column for each number of degrees of freedom."""
    measured = series(run)
    if not measured:
        return None
    families = sorted({s.k for s in measured})
    labels = sorted({s.label for s in measured})
    looks = dict(zip(labels, product(("solid", (0, (4, 1.5)), (0, (1, 1))), FAMILIES.values()), strict=False))
    figure = Figure((4.2 * len(families), 7.5))
    grid = figure.subplots(2, len(families), squeeze=False, sharex="col", sharey="row")
    for column, k in enumerate(families):
        for s in (s for s in measured if s.k == k and s.label in looks):
            _line(grid[0, column], s.times_us(), looks[s.label], s.label)
            _line(grid[1, column], s.kilobytes(), looks[s.label], "")
        sizes = sorted({n for s in measured if s.k == k for n in s.rows})
        grid[1, column].set_xticks(sizes, [str(n) for n in sizes])
        grid[1, column].set_xlabel("thrusters")
        grid[0, column].set_title(f"{k} degrees of freedom")
    time_axis(grid[0, 0].yaxis, "one call, median")
    grid[1, 0].set_ylabel("allocator [kB]")
    handles, names = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure


def _line(axes: Axes, values: dict[int, float], look: tuple[object, str], label: str) -> None:
    dashes, colour = look
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.minorticks_off()
    axes.plot(
        list(values), list(values.values()), "o", linestyle=dashes, color=colour, markersize=3, label=label
    )
