"""Wrench error over the size of the demand: who loses what, from the first limit met to twice the edge."""

from typing import TYPE_CHECKING

from bench.judging.worth import Curve
from bench.plots.style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, PURPLE, VERMILION
from bench.rows import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ALIKE = 1e-6
"""Curves that differ by less at every size are one line: what SOLVED promises of a wrench."""

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
"""One a line, in the order in which they lose: colours repeat with another dash only."""


def draw(run: Run, vehicle: str) -> "Figure | None":
    """Median and worst error over the directions tried; methods whose curves coincide share a line."""
    from matplotlib.figure import Figure

    worth = run.worth(vehicle)
    if worth is None or not worth.curves:
        return None
    figure = Figure((8.4, 4.6))
    groups = alike(worth.curves)
    left, right = figure.subplots(1, 2, sharey=True)
    _panel(left, [(names, curve.size, curve.error_p50) for names, curve in groups], "median direction")
    _panel(right, [(names, curve.size, curve.error_max) for names, curve in groups], "worst direction")
    left.set_ylabel("share of the wrench that is missed")
    figure.suptitle(f"{vehicle}: wrench error over the size of the demand", x=0.01, ha="left", fontsize=10)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def alike(curves: list[Curve]) -> list[tuple[str, Curve]]:
    """Curves that coincide taken together, least error first: (their methods' names, one of them)."""
    groups: list[tuple[list[str], Curve]] = []
    for curve in sorted(curves, key=lambda c: (sum(c.error_p50), c.method)):
        for names, other in groups:
            if _distance(curve, other) <= ALIKE:
                names.append(curve.method)
                break
        else:
            groups.append(([curve.method], curve))
    return [(", ".join(names), curve) for names, curve in groups]


def _distance(a: Curve, b: Curve) -> float:
    pairs = zip(a.error_p50 + a.error_max, b.error_p50 + b.error_max, strict=True)
    return max(abs(x - y) for x, y in pairs)


def _panel(axes: "Axes", lines: list[tuple[str, list[float], list[float]]], title: str) -> None:
    axes.axvspan(1.0, max(lines[0][1]), facecolor=FAINT, alpha=0.5)
    for (names, size, error), (colour, dash) in zip(lines, STYLES * 2, strict=False):
        axes.plot(size, error, color=colour, linestyle=dash, label=names)
    axes.set_title(title)
    axes.set_xlabel("demand / edge of the attainable set")
    axes.set_ylim(-0.02, 1.05)
