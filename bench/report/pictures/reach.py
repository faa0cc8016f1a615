"""The attainable set and the part of it with the closed form within the limits, with a mission's demands."""

from itertools import groupby

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from alloc.vehicle.geometry import unit
from bench.record import Plane
from bench.report.pictures.style import BLUE, GREEN, GREY, INK, ORANGE, VERMILION
from bench.results.rows import Run

LABELS = {
    "inactive": (GREEN, "o"),
    "active": (ORANGE, "s"),
    "boundary": (INK, "D"),
    "infeasible": (VERMILION, "x"),
}
"""Colour and marker of each label: a reader who can't tell the colours apart has the marker."""


def draw(run: Run, vehicle: str) -> Figure | None:
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
    axes.fill(*_closed(plane.attainable), facecolor=BLUE, alpha=0.15)
    axes.plot(*_closed(plane.attainable), color=BLUE, label="attainable")
    if plane.closed_form:
        axes.fill(*_closed(plane.closed_form), facecolor=GREY, alpha=0.3)
        axes.plot(
            *_closed(plane.closed_form), color=GREY, linestyle="--", label="closed form inside the limits"
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


def _closed(outline: list[tuple[float, float]]) -> tuple[list[float], list[float]]:
    points = [*outline, outline[0]]
    return [x for x, _ in points], [y for _, y in points]
