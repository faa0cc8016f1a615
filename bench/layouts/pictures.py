"""The pictures of a study: its front with the base on it, and what matters."""

from typing import TYPE_CHECKING

import numpy as np

from bench.layouts.space import Parameter
from bench.layouts.summary import OUTCOMES, StudySummary
from bench.report.pictures.style import BLUE, GREY, VERMILION

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_front(said: StudySummary, base: tuple[float, float], name: str) -> "Figure":
    """Authority whole against authority after the worst failure: all layouts, the front and the base."""
    from matplotlib.figure import Figure

    assert said.front is not None
    figure = Figure((7.5, 4.5))
    axes = figure.add_subplot()
    every = np.concatenate(said.drawn)
    axes.plot(*every.T, ".", color=GREY, markersize=2, alpha=0.5, label=f"layouts ({len(every):,} drawn)")
    whole, after = (said.front[key].to_numpy() for key in ("authority", "authority_after_one"))
    axes.plot(whole, after, "o", color=BLUE, markersize=4, label="Pareto front")
    axes.plot(*base, "D", color=VERMILION, markersize=8, label=name)
    axes.set_xlabel("authority: volume over the base's")
    axes.set_ylabel("after the worst failure")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")
    return figure


def draw_matters(said: StudySummary, parameters: tuple[Parameter, ...]) -> "Figure":
    """For each outcome, the share of its variance that each parameter alone explains."""
    from matplotlib.figure import Figure

    figure = Figure((7.5, 1.2 + 0.3 * len(parameters)))
    panels = figure.subplots(1, len(OUTCOMES), sharey=True)
    names = [parameter.name for parameter in parameters]
    for panel, outcome, shares in zip(panels, OUTCOMES, said.matters(), strict=True):
        panel.barh(names, 100 * np.nan_to_num(shares), color=BLUE)
        panel.set_title(outcome.removesuffix("_N").removesuffix("_share").replace("_", " "), fontsize=8)
        panel.set_xlim(0, 100)
        panel.grid(visible=False, axis="y")
    panels[0].invert_yaxis()
    figure.supxlabel("share of the variance explained alone [%]", fontsize=9)
    return figure
