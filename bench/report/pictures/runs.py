"""Pictures of a whole run: both sides of limits, vehicle by vehicle, and growth with thrusters."""

from itertools import product

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from alloc.formulations import Family
from bench.report.pictures.style import BLUE, BROWN, FAMILIES, GREY, INK, shorten, time_axis
from bench.report.readme import served_share
from bench.results.columns import Row
from bench.results.growth import series
from bench.results.ranking import best_rows, largest_miss, representatives
from bench.results.rows import Run

CLOSED, EXACT = FAMILIES[Family.CLOSED_FORM], FAMILIES[Family.EXACT]
WAYS = {
    "without limits, in C": (CLOSED, "o", "full"),
    "without limits, in Python": (CLOSED, "o", "none"),
    "exact within limits, in C": (EXACT, "D", "full"),
    "exact within limits, in Python": (EXACT, "D", "none"),
    "exact, by a solver's own C": (BROWN, "s", "full"),
    "exact, by the fastest solver": (BLUE, "s", "full"),
}
"""Colour, mark and filling of each way to allocate."""


def overview(run: Run) -> Figure | None:
    """Left: the median of a call, by six ways. Right, if asked: what the way without limits lacks."""
    rows = {v: representatives(best_rows(run, v, run.sets(v)[0])) for v in reversed(run.vehicles)}
    rows = {vehicle: ways for vehicle, ways in rows.items() if ways}
    if not rows:
        return None
    sides = (3, 2) if any(map(_without_limits, rows.values())) else (3,)
    figure = Figure((9.0, 1.9 + 0.34 * len(rows)))
    left, *rest = figure.subplots(1, len(sides), sharey=True, squeeze=False, width_ratios=sides)[0]
    for y, ways in enumerate(rows.values()):
        _times(left, y, ways)
    for right in rest:
        _losses(right, run, rows)
    left.set_xscale("log")
    time_axis(left.xaxis, "one call, median")
    left.set_title("What limits cost")
    left.set_yticks(range(len(rows)), map(shorten, rows))
    left.set_ylim(-0.6, len(rows) - 0.4)
    shown = [way for way in WAYS if any(way in ways for ways in rows.values())]
    marks = [
        Line2D([], [], color=colour, marker=mark, fillstyle=fill, linestyle="")  # type: ignore[arg-type]
        for colour, mark, fill in (WAYS[way] for way in shown)
    ]
    figure.legend(marks, shown, loc="outside lower center", ncols=3)
    return figure


def _times(axes: Axes, y: int, ways: dict[str, Row]) -> None:
    times = [time for row in ways.values() if (time := row.call_p50_us) is not None]
    axes.plot([min(times), max(times)], [y, y], color=GREY, linewidth=0.6)
    for way, row in ways.items():
        colour, mark, fill = WAYS[way]
        axes.plot([row.call_p50_us or 0.0], [y], mark, color=colour, fillstyle=fill, markersize=6)


def _without_limits(ways: dict[str, Row]) -> Row | None:
    return ways.get("without limits, in Python") or ways.get("without limits, in C")


def _losses(axes: Axes, run: Run, rows: dict[str, dict[str, Row]]) -> None:
    axes.set_title("What leaving them out costs")
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g} %")
    axes.set_xlabel(
        "not served within 1 % (bar)\nlargest share missing of a wrench that can be met (line)", fontsize=8
    )
    most = 100.0
    for y, (vehicle, ways) in enumerate(rows.items()):
        closed = _without_limits(ways)
        if closed is None:
            continue
        served = served_share(run, vehicle, closed)
        if served is not None:
            axes.barh([y], [100 * (1 - served)], height=0.55, color=CLOSED, alpha=0.6)
        missed = largest_miss([row for row in run.of(vehicle) if row.label == closed.label])
        if missed is not None:
            axes.plot([100 * missed, 100 * missed], [y - 0.38, y + 0.38], color=INK, linewidth=1.8)
            most = max(most, 100 * missed)  # more than the wrench is missing where thrusts turn it
    axes.set_xlim(0, most if most == 100 else 1.02 * most)


def growth(run: Run) -> Figure | None:
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
