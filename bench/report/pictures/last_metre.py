"""How much of small demands is missed, for each way to turn thrusts into commands of ESCs."""

from matplotlib.figure import Figure

from bench.report.pictures.style import BLUE, GREEN, GREY, INK, ORANGE, VERMILION
from bench.results.rows import Run

LOOKS = ((VERMILION, "s"), (ORANGE, "^"), (GREEN, "D"), (BLUE, "o"))


def draw(run: Run, vehicle: str) -> Figure | None:
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
