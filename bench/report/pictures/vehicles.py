"""Pictures of one vehicle: what it can do, wrench errors over the size of a demand, and its last metre."""

from itertools import groupby

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from alloc.allocation import WRENCH_TOLERANCE
from alloc.vehicle.geometry import unit
from bench.record import Curve, Plane
from bench.report.pictures.style import (
    BLUE,
    FAINT,
    FAMILIES,
    GREEN,
    GREY,
    INK,
    ORANGE,
    VERMILION,
    line_styles,
)
from bench.results.rows import Run

LABELS = {
    "inactive": (GREEN, "o"),
    "active": (ORANGE, "s"),
    "boundary": (INK, "D"),
    "infeasible": (VERMILION, "x"),
}
"""Colour and marker of each label: a reader who can't tell the colours apart has the marker."""


def reach(run: Run, vehicle: str) -> Figure | None:
    """Sections in the surge-sway and surge-yaw planes: all other axes zero, and the third one under load."""
    capability = run.capability(vehicle)
    if capability is None or not capability.planes:
        return None
    rows = [list(group) for _, group in groupby(capability.planes, key=lambda plane: plane.held_at != 0)]
    figure = Figure((8.4, 4.0 * len(rows) + 0.8))
    grid = figure.subplots(len(rows), max(map(len, rows)), squeeze=False)
    for line, row in zip(grid, rows, strict=True):
        for axes in line[len(row) :]:  # a section in which the vehicle can't push every way is left out
            axes.remove()
        for axes, plane in zip(line, row, strict=False):
            _section(axes, plane)
    kept = next((a.closed_form_share for a in capability.authority if a.fault is None), None)
    share = "" if kept is None else f", {100 * kept:.3g} % of its volume"
    title = f"{vehicle}: what it can do, and where f = T* τ keeps the limits{share}"
    figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    figure.legend(*_handles(figure), loc="outside lower center", ncols=3)
    return figure


def _section(axes: Axes, plane: Plane) -> None:
    axes.fill(*_close_outline(plane.attainable), facecolor=BLUE, alpha=0.15)
    axes.plot(*_close_outline(plane.attainable), color=BLUE, label="attainable")
    if plane.closed_form:
        axes.fill(*_close_outline(plane.closed_form), facecolor=GREY, alpha=0.3)
        axes.plot(
            *_close_outline(plane.closed_form),
            color=GREY,
            linestyle="--",
            label="closed form inside the limits",
        )
    for name, (colour, marker) in LABELS.items():
        points = [(x, y) for x, y, label in plane.demands if label == name]
        if points:
            xs, ys = zip(*points, strict=True)
            axes.plot(xs, ys, marker, color=colour, markersize=3.5, linestyle="", label=f"mission, {name}")
    title = (
        f"{plane.held} at {plane.held_at:.3g} {unit(plane.held)}" if plane.held_at else "all other axes zero"
    )
    axes.set_title(title)
    axes.set_xlabel(f"{plane.x} [{unit(plane.x)}]")
    axes.set_ylabel(f"{plane.y} [{unit(plane.y)}]")


def _handles(figure: Figure) -> "tuple[list[Artist], list[str]]":
    """The legend's handles and labels, each label once, over all axes of the figure."""
    by_label: dict[str, Artist] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            by_label.setdefault(label, handle)
    return list(by_label.values()), list(by_label)


def _close_outline(outline: list[tuple[float, float]]) -> tuple[list[float], list[float]]:
    points = [*outline, outline[0]]
    return [x for x, _ in points], [y for _, y in points]


def error(run: Run, vehicle: str) -> Figure | None:
    """Median and worst error over the directions tried; methods whose curves coincide share a line."""
    capability = run.capability(vehicle)
    if capability is None or not capability.curves:
        return None
    figure = Figure((8.4, 4.6))
    groups = group_curves(capability.curves)
    families = {row.method: row.family if row.family in FAMILIES else "" for row in run.rows}
    # Over all vehicles, so that a method looks the same in the pictures of each.
    measured = {curve.method for each in run.record.capabilities for curve in each.curves}
    order = [*FAMILIES, ""]
    drawn = sorted((order.index(families.get(method, "")), method) for method in measured)
    styles = line_styles((method, order[family]) for family, method in drawn)
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, title in ((left, "median direction"), (right, "worst direction")):
        axes.axvspan(1.0, max(capability.curves[0].size), facecolor=FAINT, alpha=0.5)
        axes.set_title(title)
        axes.set_xlabel("demand / edge of the attainable set")
        axes.set_ylim(-0.02, 1.05)
    for methods, curve in groups:
        colour, dash = styles[min(methods, key=list(styles).index)]  # closed forms lend a group their look
        for axes, error in ((left, curve.error_p50), (right, curve.error_max)):
            axes.plot(curve.size, error, color=colour, linestyle=dash, label=", ".join(methods))
    left.set_ylabel("share of the wrench that is missed")
    figure.suptitle(f"{vehicle}: wrench error over the size of the demand", x=0.01, ha="left", fontsize=10)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def group_curves(curves: list[Curve]) -> list[tuple[list[str], Curve]]:
    """Groups of curves that coincide, least error first: their methods, and one of the curves."""
    groups: list[tuple[list[str], Curve]] = []
    # Rounded, since Python 3.12 adds floats otherwise than 3.11: curves that coincide stand by name in both.
    for curve in sorted(curves, key=lambda c: (round(sum(c.error_p50), 12), c.method)):
        for methods, other in groups:
            if _distance(curve, other) <= WRENCH_TOLERANCE:
                methods.append(curve.method)
                break
        else:
            groups.append(([curve.method], curve))
    return groups


def _distance(a: Curve, b: Curve) -> float:
    pairs = zip(a.error_p50 + a.error_max, b.error_p50 + b.error_max, strict=True)
    return max(abs(x - y) for x, y in pairs)


LOOKS = ((VERMILION, "s"), (ORANGE, "^"), (GREEN, "D"), (BLUE, "o"))


def last_metre(run: Run, vehicle: str) -> Figure | None:
    """Median, and a line to 95 %, over the size of the demand; grey is what steps alone explain."""
    capability = run.capability(vehicle)
    if capability is None or not capability.last_metre:
        return None
    figure = Figure((8.4, 3.6))
    axes = figure.subplots()
    for k, (each, (colour, marker)) in enumerate(zip(capability.last_metre, LOOKS, strict=False)):
        for i, (p50, p95) in enumerate(zip(each.error_p50, each.error_p95, strict=True)):
            x = i + 0.18 * (k - 1.5)
            axes.plot([x, x], [100 * p50, 100 * p95], color=colour)
            axes.plot(x, 100 * p50, marker, color=colour, linestyle="", label="" if i else each.way)
    last = capability.last_metre[-1]
    for i, step in enumerate(last.step_p50):
        axes.plot(
            [i - 0.4, i + 0.4],
            [100 * step] * 2,
            color=GREY,
            dashes=(3, 2),
            label="" if i else "by steps alone",
        )
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.set_ylabel("share of the wrench that is missed [%]")
    axes.set_xticks(range(len(last.share)), [f"{100 * share:g} %" for share in last.share])
    axes.set_xlabel("demand / edge of the attainable set")
    axes.axhline(100, color=INK, linewidth=0.5)
    figure.suptitle(f"{vehicle}: what the last metre costs", x=0.01, ha="left", fontsize=10)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
