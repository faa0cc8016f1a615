"""Wrench error of each method over the size of the demand, up to twice the edge of the attainable set."""

from matplotlib.figure import Figure

from alloc.allocation import WRENCH_TOLERANCE
from bench.record import Curve
from bench.report.pictures.style import FAINT, FAMILIES, looks
from bench.results.rows import Run


def draw(run: Run, vehicle: str) -> Figure | None:
    """Median and worst error over the directions tried; methods whose curves coincide share a line."""
    capability = run.capability(vehicle)
    if capability is None or not capability.curves:
        return None
    figure = Figure((8.4, 4.6))
    groups = alike(capability.curves)
    families = {row.method: row.family if row.family in FAMILIES else "" for row in run.rows}
    # Over all vehicles, so that a method looks the same in the pictures of each.
    measured = {curve.method for each in run.record.capabilities for curve in each.curves}
    order = [*FAMILIES, ""]
    drawn = sorted((order.index(families.get(method, "")), method) for method in measured)
    styles = looks((method, order[family]) for family, method in drawn)
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


def alike(curves: list[Curve]) -> list[tuple[list[str], Curve]]:
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
