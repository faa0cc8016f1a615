"""Wrench error of each method over the size of the demand, up to twice the edge of the attainable set."""

from collections.abc import Iterable
from itertools import cycle
from typing import TYPE_CHECKING

from alloc import WRENCH_TOLERANCE
from bench.record import Curve
from bench.report.pictures.style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, PURPLE, VERMILION
from bench.results.rows import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLES = (
    (GREY, "-"),
    (VERMILION, "-"),
    (BLUE, "-"),
    (GREEN, "--"),
    (ORANGE, "-"),
    (PURPLE, "--"),
    (INK, ":"),
    (BLUE, ":"),
    (VERMILION, "--"),
    (GREEN, "-."),
)
"""Colour and dash of each method; a colour repeats only with another dash."""


def draw(run: Run, vehicle: str) -> "Figure | None":
    """Median and worst error over the directions tried; methods whose curves coincide share a line."""
    from matplotlib.figure import Figure

    capability = run.capability(vehicle)
    if capability is None or not capability.curves:
        return None
    figure = Figure((8.4, 4.6))
    groups = alike(capability.curves)
    styles = styles_of(curve.method for each in run.record.capabilities for curve in each.curves)
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, title in ((left, "median direction"), (right, "worst direction")):
        axes.axvspan(1.0, max(capability.curves[0].size), facecolor=FAINT, alpha=0.5)
        axes.set_title(title)
        axes.set_xlabel("demand / edge of the attainable set")
        axes.set_ylim(-0.02, 1.05)
    for methods, curve in groups:
        colour, dash = styles[min(methods)]
        for axes, error in ((left, curve.error_p50), (right, curve.error_max)):
            axes.plot(curve.size, error, color=colour, linestyle=dash, label=", ".join(methods))
    left.set_ylabel("share of the wrench that is missed")
    figure.suptitle(f"{vehicle}: wrench error over the size of the demand", x=0.01, ha="left", fontsize=10)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def styles_of(methods: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Colour and dash of each method, the same in the pictures of all vehicles of a run."""
    return dict(zip(sorted(set(methods)), cycle(STYLES), strict=False))


def alike(curves: list[Curve]) -> list[tuple[list[str], Curve]]:
    """Groups of curves that coincide, least error first: their methods, and one of the curves."""
    groups: list[tuple[list[str], Curve]] = []
    for curve in sorted(curves, key=lambda c: (sum(c.error_p50), c.method)):
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
