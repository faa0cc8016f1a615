"""Pictures of methods: cost, loss, period and tails on a vehicle; limits and growth of a whole run."""

from itertools import product

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator

from alloc.allocation import WRENCH_TOLERANCE
from alloc.formulations import Family
from bench.report.pictures.style import (
    BLUE,
    BROWN,
    FAINT,
    FAMILIES,
    GREEN,
    GREY,
    INK,
    PAPER,
    VERMILION,
    add_legend,
    colour,
    label_points,
    line_styles,
    share_axis,
    shorten,
    time_axis,
    title_with_count,
)
from bench.results.columns import Row
from bench.results.growth import series
from bench.results.quantiles import Histogram, total
from bench.results.ranking import (
    best_rows,
    choose_rows,
    largest_loss,
    largest_miss,
    pareto_front,
    representatives,
    served_share,
)
from bench.results.rows import Run

MOST = 12
"""Most methods in one picture."""


def cost(run: Run, vehicle: str) -> Figure | None:
    """Median of each method as a dot, a thick whisker to p99.9, a thin one to the slowest call."""
    demands = run.sets(vehicle)[0]
    every = best_rows(run, vehicle, demands)
    rows = choose_rows(every, MOST)[::-1]
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
        f"one call: median on {shorten(demands)} demands (dot),"
        "\non all sets p99.9 (thick line) and slowest (bar)",
    )
    axes.set_yticks(range(len(rows)), [shorten(row.label) for row in rows])
    axes.set_ylim(-0.7, len(rows) - 0.3)
    axes.grid(axis="y", visible=False)
    axes.set_title(title_with_count(vehicle, len(rows), len(every)))
    add_legend(figure, rows)
    return figure


FLOOR = WRENCH_TOLERANCE
"""A wrench missed by less counts as met and is drawn at this height, because a log axis has no zero."""


def pareto(run: Run, vehicle: str) -> Figure | None:
    """Worst share of the wrench lost over median time; the line joins the Pareto front."""
    demands = run.sets(vehicle)[0]
    every = best_rows(run, vehicle, demands)
    points = [
        (time, max(error, FLOOR), row)
        for row in choose_rows(every, MOST)
        if (time := row.call_p50_us) and (error := largest_loss(row)) is not None
    ]
    if not points:
        return None
    figure = Figure((7.5, 5))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    kept = pareto_front([(time, error) for time, error, _ in points])
    axes.step(*zip(*kept, strict=True), where="post", color=FAINT, linewidth=4, zorder=1)
    for time, error, row in points:
        axes.plot([time], [error], "o", color=colour(row), markersize=5)
    time_axis(axes.xaxis, "one call, median")
    share_axis(axes.yaxis, "largest share of a demand's wrench that is lost", floor=FLOOR)
    axes.set_title(title_with_count(f"{vehicle}, {demands} demands", len(points), len(every)))
    add_legend(figure, [row for *_, row in points])
    on_front = set(kept)
    # Points of the front come first, so their labels get the best places.
    ordered = sorted(points, key=lambda point: point[:2] not in on_front)
    named = [(time, error, row.method) for time, error, row in ordered]
    label_points(axes, named)
    return figure


RATES_HZ = {50: (GREEN, "o"), 100: (BLUE, "s"), 400: (VERMILION, "^")}
"""Colour and mark of each control rate."""


def period(run: Run, vehicle: str) -> Figure | None:
    """p99 over the period as a mark for each rate; 100 % is a missed deadline.

    p99 is of the single calls on all of the vehicle's demand sets. Where there are too few calls for it, a
    hollow mark shows the slowest call.
    """
    shown: list[tuple[str, float, bool]] = []
    every = best_rows(run, vehicle, run.sets(vehicle)[0])
    for row in choose_rows(every, MOST):
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
    axes.set_yticks(range(len(shown)), [shorten(label) for label, _, _ in shown])
    axes.set_ylim(-0.7, len(shown) - 0.3)
    axes.set_xlabel("p99 of a call (hollow: slowest of too few), share of the control period")
    axes.set_title(title_with_count(f"{vehicle}, all demand sets", len(shown), len(every)))
    marks = [Line2D([], [], color=c, marker=m, linestyle="") for c, m in RATES_HZ.values()]
    figure.legend(marks, [f"{rate} Hz" for rate in RATES_HZ], loc="outside lower center", ncols=3)
    return figure


MOST_CURVES = 10
"""Most curves in one picture."""


def tails(run: Run, vehicle: str) -> Figure | None:
    """A curve for each of the telling methods down to its slowest call, labelled at the right."""
    demands = run.sets(vehicle)[0]
    every = best_rows(run, vehicle, demands)
    rows = choose_rows([row for row in every if row.measured.singles], MOST_CURVES)
    if not rows:
        return None
    figure = Figure((7.5, 4.6))
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    styles = line_styles((row.label, row.family) for row in rows)
    for row in rows:
        times, share = tail_curve(row.measured.singles)
        colour, dashes = styles[row.label]
        axes.step(
            times, share, where="pre", color=colour, linestyle=dashes, linewidth=1.3, label=shorten(row.label)
        )
        axes.plot(times[-1:], share[-1:], "o", color=colour, markersize=3.5)
    time_axis(axes.xaxis, "one call")
    share_axis(axes.yaxis, "calls that took at least so long (dot: the slowest)")
    axes.set_title(title_with_count(f"{vehicle}, {demands} demands, single calls", len(rows), len(every)))
    figure.legend(loc="outside right upper", title="by median")
    return figure


def tail_curve(counted: Histogram) -> tuple[list[float], list[float]]:
    """Times [us] and the share of calls that took at least each: from all calls to the slowest."""
    n = left = total(counted)
    times, share = [], []
    for ns, count in counted:
        times.append(ns / 1000)
        share.append(left / n)
        left -= count
    return times, share


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
        missed = largest_miss([row for row in run.select(vehicle) if row.label == closed.label])
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
