"""Pictures for `thrustbench check`: the vehicle, its probe table, and the thrust curve of an ESC.

The views are the same in every frame; their axes have the signs of the vehicle's own.
"""

import textwrap
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.lint.autopilot import INPUTS
from alloc.lint.probe import SMALL, Probe
from alloc.vehicle.esc import Esc
from alloc.vehicle.file import Mounting
from alloc.vehicle.frame import TURN, described
from alloc.vehicle.geometry import DOF
from bench.report.pictures.style import (
    BLUE,
    FAINT,
    GREY,
    INK,
    PAPER,
    VERMILION,
    ignore_missing_letters,
    label_points,
)

LONG_ARROW = 0.28
"""Length of an arrow in the plane of the page, over the vehicle's largest extent."""
SHORT_ARROW = 0.4
"""Least length of an arrow beside polygons, over that of the largest force: circles hide shorter ones."""
STRAIGHT = 0.15
"""A direction whose part in the plane is shorter than this points out of the page or into it."""

MARK = 8.0
"""Half the width of a thruster's circle [px at 72 dpi]: names stand beside it."""
ALONG = (0.25, 0.5, 0.75, 1.0)
"""Places on an arrow, over its length, that names leave free, as wide as a circle."""


class View(NamedTuple):
    """One of the views.

    Attributes
    ----------
    title : what it shows
    right, up : the body axis (0, 1, 2) that points right or up on the page, and its sign in frd
    towards : the body axis that points at the reader, and its sign in frd
    sides : words at the left, right, lower and upper edge
    """

    title: str
    right: tuple[int, int]
    up: tuple[int, int]
    towards: tuple[int, int]
    sides: tuple[str, str, str, str]


VIEWS = (
    View("from above", (1, 1), (0, 1), (2, -1), ("port", "starboard", "aft", "ahead")),
    View("from ahead", (1, -1), (2, -1), (0, 1), ("starboard", "port", "down", "up")),
    View("from starboard", (0, 1), (2, -1), (1, 1), ("aft", "ahead", "down", "up")),
)


def views(frame: str) -> list[View]:
    """The views with the signs of the axes in a frame."""
    if frame == "frd":
        return list(VIEWS)

    def turned(axis: tuple[int, int]) -> tuple[int, int]:
        return axis[0], axis[1] * int(TURN[axis[0]])

    return [
        view._replace(right=turned(view.right), up=turned(view.up), towards=turned(view.towards))
        for view in VIEWS
    ]


def sketch(vehicle: Vehicle, poses: Mounting) -> Figure:
    """The figure of a vehicle, to be made and saved within the settings of ``style``.

    Only thrusters that turn or stand on a line of thrust are drawn; the others are listed. ``poses`` has one
    entry for each thruster; of one that turns, its direction is 0 and its polygon is drawn from above.
    """
    figure = Figure(figsize=(9, 8.2))
    grid = figure.subplots(2, 2)
    standing = np.flatnonzero(poses.stands)
    drawn = poses._replace(positions=poses.positions[standing], directions=poses.directions[standing])
    extent = float(np.ptp(np.vstack([drawn.positions, poses.center]), axis=0).max()) or 1.0
    most = _largest_forces(vehicle)
    scale = LONG_ARROW * extent / float(most.max()) if vehicle.azimuths else 0.0
    least = SHORT_ARROW if vehicle.azimuths else 1.0
    lengths = np.maximum(scale * most[standing], least * LONG_ARROW * extent)
    seen = views(vehicle.frame)
    for axes, view in zip((grid[0, 0], grid[0, 1], grid[1, 0]), seen, strict=True):
        _draw(axes, view, drawn, standing.tolist(), lengths, extent)
    for azimuth in vehicle.azimuths:
        (place,) = _project(seen[0], poses.positions[[vehicle.actuators.index(tuple(azimuth.components))]])
        for part in azimuth.parts:
            corners = place + scale * _project(seen[0], part.corners)
            grid[0, 0].add_patch(Polygon(corners, facecolor=(BLUE, 0.12), edgecolor=BLUE, linewidth=1.6))
    _listing(grid[1, 1], vehicle, poses)
    shown = "arrows and polygons show how" if vehicle.azimuths else "arrows show which way positive"
    figure.suptitle(f"{vehicle.name}: {shown} thrust pushes the vehicle", fontsize=10)
    _add_names(grid[0, 0], seen[0], drawn, [vehicle.names[i] for i in standing if vehicle.names], lengths)
    return figure


def _largest_forces(vehicle: Vehicle) -> FloatArray:
    """Largest force (a,) of each thruster, either way or at any angle [N]."""
    largest = np.maximum(np.abs(vehicle.f_min), np.abs(vehicle.f_max))
    for azimuth in vehicle.azimuths:
        largest[azimuth.first] = np.linalg.norm(azimuth.corners, axis=1).max()
    return largest[[first for first, *_ in vehicle.actuators]]


def _draw(
    axes: Axes, view: View, poses: Mounting, thrusters: list[int], lengths: FloatArray, extent: float
) -> None:
    points, arrows = _project(view, poses.positions), _project(view, poses.directions)
    facing = view.towards[1] * poses.directions[:, view.towards[0]]
    arrow = {"arrowstyle": "-|>,head_width=0.25,head_length=0.5", "color": BLUE, "linewidth": 1.6}
    for point, along, out, reach in zip(points, arrows, facing, lengths, strict=True):
        length = float(np.hypot(*along))
        if length > STRAIGHT:
            tip = point + reach * along
            axes.annotate("", tuple(tip), tuple(point), arrowprops=arrow)
        elif abs(out) > STRAIGHT:  # an arrow's tip, or its feathers
            axes.plot(*point, "o", markersize=21, markerfacecolor="none", markeredgecolor=BLUE)
            if out < 0:
                axes.plot(*point, "x", markersize=15, color=BLUE)
    for point, numbers in _group_points(points, 0.02 * extent):
        axes.plot(*point, "o", markersize=14, markerfacecolor=PAPER, markeredgecolor=INK, zorder=3)
        text, size = " ".join(str(thrusters[i]) for i in numbers), 7 if len(numbers) < 3 else 5
        axes.text(point[0], point[1], text, ha="center", va="center", fontsize=size, zorder=4)
    axes.plot(*_project(view, poses.center[None])[0], "P", color=VERMILION, markersize=7, zorder=4)
    _set_frame(axes, view, points, extent)


def _add_names(axes: Axes, view: View, poses: Mounting, names: list[str], lengths: FloatArray) -> None:
    """Names beside the thrusters, where they cover neither each other nor circles and arrows."""
    points, arrows = _project(view, poses.positions), lengths[:, None] * _project(view, poses.directions)
    along = [point + share * arrow for point, arrow in zip(points, arrows, strict=True) for share in ALONG]
    named = [(x, y, name) for (x, y), name in zip(points, names, strict=False)]
    with ignore_missing_letters():
        label_points(axes, [*named, *((x, y, "") for x, y in along)], 6.5, MARK)


def _set_frame(axes: Axes, view: View, points: FloatArray, extent: float) -> None:
    """Room for the arrows, words at the edges, and metres."""
    middle = (points.max(axis=0) + points.min(axis=0)) / 2
    half = extent * (0.5 + 1.35 * LONG_ARROW)
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)
    axes.set_aspect("equal")
    left, right, low, high = view.sides
    names = [f"{'-' if sign < 0 else ''}{'xyz'[axis]}" for axis, sign in (view.right, view.up)]
    axes.set_title(f"seen {view.title}")
    axes.set_xlabel(f"{left}  ←  {names[0]} [m]  →  {right}")
    axes.set_ylabel(f"{low}  ←  {names[1]} [m]  →  {high}")
    axes.axhline(0, color=FAINT, linewidth=1.2)
    axes.axvline(0, color=FAINT, linewidth=1.2)


def _listing(axes: Axes, vehicle: Vehicle, poses: Mounting) -> None:
    """Names and limits of the thrusters, and what the signs mean."""
    axes.axis("off")
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    size = min(8.5, 150 / (len(vehicle.actuators) + 6))
    step = 1 / (len(vehicle.actuators) + 6)
    rows = [("", "thruster", "limits [N]")]
    most = _largest_forces(vehicle)
    for i, (first, *second) in enumerate(vehicle.actuators):
        stands = "" if poses.stands[i] else " (not drawn)"
        limits = f"{vehicle.f_min[first]:.4g} … {vehicle.f_max[first]:.4g}"
        limits = f"turns, up to {most[i]:.4g}" if second else limits
        rows.append((str(i), ((vehicle.names and vehicle.names[i]) or "") + stands, limits))
    for line, (number, name, limits) in enumerate(rows):
        y = 1 - (line + 0.5) * step
        for x, text, side in ((0.05, number, "right"), (0.1, name, "left"), (1.0, limits, "right")):
            axes.text(x, y, text, ha=side, va="center", fontsize=size, color=INK if line else GREY)
    remarks = [
        f"+ centre of mass; frame {described(vehicle.frame)}",
        "ring: pushes towards you; ring with a cross: away from you",
    ]
    if vehicle.azimuths:
        remarks.append("polygons are drawn from above alone; an arrow is as long as")
        remarks.append(f"its larger limit on their scale, at least {SHORT_ARROW} of the longest")
    if not poses.measured:
        remarks.append("the file gives T alone: each thruster stands where its")
        remarks.append("line of thrust is nearest to the centre of mass")
    if not poses.stands.all():
        remarks.append("not drawn: no line of thrust makes that column of T")
    for line, text in enumerate(remarks):
        axes.text(0, (len(remarks) - line - 0.5) * 0.045, text, va="center", fontsize=7.5, color=GREY)


def _project(view: View, points: FloatArray) -> FloatArray:
    """(n, 2) of points or directions (n, 3) on the page of a view."""
    (right, right_sign), (up, up_sign) = view.right, view.up
    return np.stack([right_sign * points[:, right], up_sign * points[:, up]], axis=1)


def _group_points(points: FloatArray, near: float) -> list[tuple[FloatArray, list[int]]]:
    """Points (n, 2) that fall on each other in a view, with the thrusters that sit there."""
    groups: list[tuple[FloatArray, list[int]]] = []
    for i, point in enumerate(points):
        for other, numbers in groups:
            if np.hypot(*(point - other)) <= near:
                numbers.append(i)
                break
        else:
            groups.append((point, [i]))
    return groups


COLUMNS = (0.0, 0.22, 0.32, 0.66, 0.94)
"""Left edges of the columns: thruster, thrust, words, numbers, boxes."""
WIDTHS = (22, 10, 44, 34)
"""Letters of a line in each column but the last."""


def sheet(vehicle: Vehicle, found: Sequence[Probe]) -> Figure:
    """The figure, to be made and saved within the settings of ``style``."""
    rows = [(p.thruster, f"{p.thrust:+.3g} N", p.words, p.numbers) for p in found]
    cells = [
        [textwrap.wrap(text, width) or [""] for text, width in zip(row, WIDTHS, strict=True)] for row in rows
    ]
    heights = [max(map(len, row)) + 0.7 for row in cells]
    total = 5.0 + sum(heights)
    figure = Figure(figsize=(9, 0.19 * total))
    figure.set_layout_engine("none")  # everything has its place below
    axes = figure.add_axes((0.04, 0.02, 0.93, 0.96))
    axes.axis("off")
    axes.set_xlim(0, 1)
    axes.set_ylim(total, 0)
    axes.text(0, 0.6, f"{vehicle.name}: each thruster alone, a tenth of its thrust", fontsize=11, va="center")
    axes.text(0, 1.9, f"frame {described(vehicle.frame)}", fontsize=8, color=GREY, va="center")
    header = ("thruster", "thrust", "what it should do", "in its frame", "yes")
    for x, text in zip(COLUMNS, header, strict=True):
        axes.text(x, 3.4, text, fontsize=8, color=GREY, va="center")
    y = 4.2
    for row, height in zip(cells, heights, strict=True):
        axes.plot([0, 1], [y, y], color=FAINT, linewidth=0.8)
        for x, lines in zip(COLUMNS, row, strict=False):
            axes.text(x, y + 0.35, "\n".join(lines), fontsize=8.5, color=INK, va="top", linespacing=1.25)
        box = Rectangle((COLUMNS[-1], y + 0.35), 0.018, 0.8, fill=False, edgecolor=INK, linewidth=1)
        axes.add_patch(box)
        y += height
    if any(probe.small for probe in found):
        axes.text(0, y + 0.5, SMALL, fontsize=7, color=GREY, va="top")
    return figure


def input_map(vehicle: Vehicle, percent: FloatArray, frame: str) -> Figure:
    """Table (6, 6) of each input's percentages along each axis (``alloc.lint.autopilot.shares``), coloured.

    Blue on the diagonal and vermilion beside it, the fuller the more.
    """
    figure = Figure((7.2, 4.4))
    axes = figure.subplots()
    for (row, column), cell in np.ndenumerate(percent.round(1) + 0.0):
        if np.isfinite(cell):
            colour = BLUE if row == column else VERMILION
            full = 0.6 * min(abs(cell) / 100, 1.0)
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, color=colour, alpha=full, linewidth=0))
            axes.text(column, row, f"{cell:.1f}", ha="center", va="center", color=INK, fontsize=8)
    axes.grid(visible=False)
    axes.set(xlim=(-0.5, 5.5), ylim=(5.5, -0.5))
    axes.set_xticks(range(6), INPUTS)
    axes.set_yticks(range(6), DOF)
    axes.set_xlabel("input at 1: diagonal, % of what all thrusters could do; beside it, % of the axis's own")
    figure.suptitle(f"{vehicle.name}: what {frame} makes", x=0.01, ha="left", fontsize=10)
    return figure


def thrust_curve(vehicle: Vehicle) -> Figure:
    """One panel for each ESC of the vehicle that differs from the others."""
    thrusters: dict[Esc, list[str]] = {}
    for i, esc in enumerate(vehicle.esc):
        thrusters.setdefault(esc, []).append(vehicle.called(i))
    figure = Figure((8.4, 3.2 * len(thrusters) + 0.6))
    panels = figure.subplots(len(thrusters), 1, squeeze=False)[:, 0]
    for axes, (esc, names) in zip(panels, thrusters.items(), strict=True):
        own = [i for i, other in enumerate(vehicle.esc) if other is esc]
        ends = float(vehicle.f_min[own].min()), float(vehicle.f_max[own].max())
        _panel(axes, esc, ends)
        if len(thrusters) > 1:
            axes.set_title(", ".join(names), loc="left")
    figure.suptitle(f"{vehicle.name}: thrust of a command", x=0.01, ha="left", fontsize=10)
    return figure


def _panel(axes: Axes, esc: Esc, ends: tuple[float, float]) -> None:
    u = 2 * esc.neutral - esc.command if esc.reversed else esc.command
    # The voltage that calls take where they name none stands out.
    chosen = esc.nominal if np.isfinite(esc.nominal) else esc.volts[0]
    for volts, f in zip(esc.volts, esc.curve, strict=True):
        nominal = volts == chosen or len(esc.volts) == 1
        axes.plot(u, f, color=BLUE if nominal else GREY, linewidth=1.6 if nominal else 0.8)
        if np.isfinite(volts):
            axes.annotate(f"{volts:g} V", (u[-1], f[-1]), color=INK, fontsize=7)
    still = u[(esc.at(np.array([chosen]))[0] == 0)]
    dead = still.size > 0 and still.min() < still.max()  # else the curve is zero at neutral alone
    if dead:
        axes.axvspan(float(still.min()), float(still.max()), facecolor=FAINT)
    for end in ends:
        axes.axhline(end, color=VERMILION, linestyle="--", linewidth=0.8)
    axes.axhline(0.0, color=INK, linewidth=0.5)
    shaded = "; shaded: the dead band" if dead else ""
    axes.set_xlabel(f"command, {esc.low:g} to {esc.high:g} by {esc.step:g}{shaded}")
    axes.set_ylabel("thrust [N]; dashed: limits")
