"""Draws docs/exact.svg: ``python docs/studies/nullspace_picture.py docs/exact.svg``.

A supply vessel with one thruster off has five thrusters, and two dimensions are left once the wrench is met.
Each thruster's limits are a strip of the z plane. The picture shows the strips, the polygon that they share,
and the path of z as the method adds the strips one by one.
"""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from alloc import Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.nullspace.region import prepare
from alloc.nullspace.structure import Block, decompose
from bench.demands import build_demands
from bench.report.pictures.style import BLUE, FAINT, GREEN, GREY, INK, SETTINGS, VERMILION, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FAULT = 0
VISIBLE = 0.1
"""Shortest move that is easy to see, relative to the distance of the answer."""
HALF = np.array([1.35, 0.95])
"""Half the picture's width and height, relative to the farthest coordinate on the path."""
FAR = 0.5
"""Smallest distance of an answer to draw, relative to the largest limit: nearer ones show no polygon."""
CORNER = 0.1
"""Shortest line to draw, relative to the picture: a shorter one only cuts a corner off."""
GRID = 700
"""Points on each side of the grid at which the plane is tested: finer than a pixel."""


def path(A: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Path of z (m + 1, 2): the optimum of the first i rows, for i = 0 to m."""
    points = [np.zeros(2)]
    for i in range(1, len(A) + 1):
        z, _ = prepare(A[:i], 0.0).nearest(lower[:i].tolist(), upper[:i].tolist()) if i > 1 else (None, 0)
        points.append(one_strip(A[0], lower[0], upper[0]) if i == 1 else np.array(z))
    return np.array(points)


def one_strip(a: FloatArray, low: float, high: float) -> FloatArray:
    """The point of low <= a'z <= high nearest to the origin."""
    nearest: FloatArray = a * (np.clip(0.0, low, high) / (a @ a))
    return nearest


def interesting(vehicle: Vehicle, block: Block) -> FloatArray:
    """The seeded active demand on whose path z makes the most visible moves, then the longest."""

    def moves(tau: FloatArray) -> tuple[bool, int, float]:
        points = path(block.N, *strips(vehicle, block, tau))
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.linalg.norm(points[-1])
        visible = steps[steps > VISIBLE]
        far = float(np.linalg.norm(points[-1])) > FAR * vehicle.f_scale
        return far, len(visible), float(visible.min(initial=1.0))

    demand: FloatArray = max(build_demands("active", vehicle, 0, 200).taus, key=moves)
    return demand


def strips(vehicle: Vehicle, block: Block, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lower and upper limit of each row of N z."""
    x = (decompose(vehicle).G @ tau)[block.rows]
    return vehicle.f_min[block.rows] - x, vehicle.f_max[block.rows] - x


def draw() -> "Figure":
    """The figure: strips, polygon, circles of equal cost, the path of z."""
    from matplotlib.figure import Figure

    vehicle = load_vehicle("supply-vessel").with_fault(FAULT)
    (block,) = decompose(vehicle).blocks
    tau = interesting(vehicle, block)
    lower, upper = strips(vehicle, block, tau)
    points = path(block.N, lower, upper)
    f = build("nullspace", vehicle)(tau).f
    assert np.allclose(f[block.rows], (decompose(vehicle).G @ tau)[block.rows] + block.N @ points[-1])
    kN = 1e3
    figure = Figure((7.5, 5.6))
    axes = figure.add_subplot(aspect="equal")
    reach = np.abs(points).max() / kN
    middle = (points.max(axis=0) + points.min(axis=0)) / 2 / kN
    box = np.array([middle - reach * HALF, middle + reach * HALF])
    axes.set(xlim=box[:, 0], ylim=box[:, 1])
    lines(axes, block, lower / kN, upper / kN, box)
    angle = np.linspace(0, 2 * np.pi, 200)
    for radius in np.linalg.norm(np.unique(points.round(6), axis=0), axis=1) / kN:
        axes.plot(radius * np.cos(angle), radius * np.sin(angle), color=GREY, linewidth=0.7, linestyle=":")
    axes.plot(*points.T / kN, "o-", color=VERMILION, markersize=5, zorder=4)
    axes.plot(0, 0, "o", color=INK, markersize=6, zorder=5)
    axes.annotate("0: f = Gτ", (0, 0), xytext=(6, -12), textcoords="offset points")
    axes.annotate(
        "z: the answer", tuple(points[-1] / kN), xytext=(8, 6), textcoords="offset points", color=VERMILION
    )
    axes.set(xlabel="z₁ [kN]", ylabel="z₂ [kN]")
    axes.set_title(f"{vehicle.name}, an active demand: strips of {len(block.rows)} thrusters, d = 2", pad=16)
    axes.grid(color=FAINT)
    return figure


def lines(axes: "Axes", block: Block, lower: FloatArray, upper: FloatArray, box: FloatArray) -> None:
    """Draw the polygon that all strips share, and each strip's edges with the thruster's number."""
    x, y = np.linspace(box[0], box[1], GRID).T
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    inside = np.full((GRID, GRID), np.inf)
    for a, low, high in zip(block.N, lower, upper, strict=True):
        inside = np.minimum(inside, np.minimum(grid @ a - low, high - grid @ a))
    axes.contourf(x, y, inside, levels=[0, np.inf], colors=[GREEN], alpha=0.35)
    for thruster, a, low, high in zip(block.rows, block.N, lower, upper, strict=True):
        for bound, name in ((low, "min"), (high, "max")):
            ends = crossing(a * bound / (a @ a), np.array([-a[1], a[0]]), box)
            if ends is not None and np.ptp(ends, axis=0).max() > CORNER * np.ptp(box):
                axes.plot(*ends.T, color=BLUE, linewidth=1.2)
                at, foot = sorted(ends, key=lambda end: -end[1] - 0.01 * end[0])
                side = "left" if at[0] > foot[0] else "right"
                axes.annotate(
                    f"$f_{thruster}$ {name}", at, xytext=(0, 3), textcoords="offset points", color=BLUE,
                    ha=side, fontsize=8, annotation_clip=False, parse_math=True,
                )  # fmt: skip


def crossing(start: FloatArray, along: FloatArray, box: FloatArray) -> FloatArray | None:
    """The two points where a line enters and leaves the box; None where it misses it."""
    sides = (box - start) / np.where(along == 0, 1e-300, along)
    first, last = np.sort(sides, axis=0)
    if first.max() >= last.min():
        return None
    ends: FloatArray = start + np.outer([first.max(), last.min()], along)
    return ends


def main() -> None:
    """Write the picture to the path given."""
    from matplotlib import rc_context

    with rc_context(SETTINGS):
        save(draw(), Path(sys.argv[1]))


if __name__ == "__main__":
    main()
