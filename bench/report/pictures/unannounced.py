"""Picture of failures that nobody announces: what is lost until the allocator knows."""

from matplotlib.figure import Figure

from bench.report.pictures.style import BLUE, GREEN, INK, ORANGE, VERMILION, shorten
from bench.results.failures import by_failure, shown_method, thruster_names
from bench.results.rows import Run

LOOKS = {"off": (VERMILION, "s"), "stuck": (ORANGE, "^"), "half": (GREEN, "D"), "reversed": (BLUE, "o")}
"""Colour and mark of each failure."""
STEP = 0.18
"""Distance between the failures of one thruster, of that between two thrusters."""


def unannounced(run: Run, vehicle: str) -> Figure | None:
    """Median share of a demand that is delivered, and a line to the worst; hollow: once announced."""
    capability = run.capability(vehicle)
    if capability is None or (method := shown_method(capability)) is None:
        return None
    costs = by_failure(capability, method)
    announced = by_failure(capability, method, announced=True)
    names = thruster_names(capability)
    figure = Figure((8.4, 3.8))
    axes = figure.subplots()
    for k, (failure, cost) in enumerate(costs.items()):
        colour, mark = LOOKS[failure]
        at = [i + STEP * (k - 1.5) for i in range(len(names))]
        middle, least = ([100 * share for share in each] for each in (cost.share_p50, cost.share_min))
        axes.vlines(at, least, middle, color=colour)
        axes.plot(at, middle, mark, color=colour, label=failure)
        if failure in announced:
            known = [100 * share for share in announced[failure].share_p50]
            axes.plot(at, known, mark, color=colour, fillstyle="none", markersize=8)
    axes.axhline(0, color=INK, linewidth=0.5)
    axes.set_xticks(range(len(names)), [shorten(name, 12) for name in names])
    axes.set_xlabel("thruster that fails")
    axes.set_ylabel("delivered along the demand [%]")
    figure.suptitle(f"{vehicle}: what you lose until you know ({method})", x=0.01, ha="left", fontsize=10)
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=4,
        title="median (mark), worst demand (line), median once announced (hollow)",
    )
    return figure
