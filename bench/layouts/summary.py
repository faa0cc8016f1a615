"""Summary of all shards of a study: Pareto front, rank of the base, what each parameter changes."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from bench.layouts.measure import Columns, measure
from bench.layouts.shards import read_shard, shard_facts, whole_shards
from bench.layouts.space import LayoutSpace, Parameter

if TYPE_CHECKING:
    import pyarrow as pa

MORE = ("authority", "authority_after_one", "exact_served_share")
LESS = ("worst_case_steps", "thrusters")
"""Columns to compare: authority, whole and after the worst failure, demands served, and its price."""


def losses(table: "pa.Table") -> FloatArray:
    """(M, 5) what counts of each layout, the less the better; a cost that is not known counts as infinite."""
    more = [-table[name].to_numpy() for name in MORE]
    less = [np.nan_to_num(table[name].to_numpy().astype(float), nan=np.inf) for name in LESS]
    return np.array([*more, *less]).T


def unbeaten(points: FloatArray) -> BoolArray:
    """Mask of points (M, p) that no other equals or beats in all coordinates; the first of equal ones counts.

    Sorted, a point can only be beaten by one before it.
    """
    order = np.lexsort(points.T[::-1])
    kept = np.zeros(len(points), dtype=bool)
    front = np.empty((0, points.shape[1]))
    for i in order:
        if not (front <= points[i]).all(axis=1).any():
            front = np.vstack([front, points[i]])
            kept[i] = True
    return kept


def merged(front: "pa.Table | None", shard: "pa.Table") -> "pa.Table":
    """The front of a front and a shard's rows."""
    import pyarrow as pa

    points = losses(shard)
    if front is not None:
        beaten = np.zeros(len(points), dtype=bool)
        for better in losses(front):
            beaten |= (better <= points).all(axis=1)
        shard = pa.concat_tables([front, shard.filter(pa.array(~beaten))])
        points = losses(shard)
    return shard.filter(pa.array(unbeaten(points)))


def spread(front: "pa.Table", count: int) -> "pa.Table":
    """At most ``count`` layouts of a front, evenly along their authority, the most authority first."""
    order = np.lexsort(
        [front["layout"].to_numpy(), front["round"].to_numpy(), -front["authority"].to_numpy()]
    )
    places = np.unique(np.linspace(0, len(order) - 1, min(count, len(order))).round().astype(int))
    return front.take(order[places])


OUTCOMES = ("authority", "authority_after_one", "any_direction_N", "closed_form_volume_share")
"""Numbers of a layout of which it is said what matters for them."""

COMPARED = (
    "authority",
    "authority_after_one",
    "authority_after_two",
    "any_direction_N",
    "unannounced_share",
    "safe_share",
    "closed_form_volume_share",
    "closed_form_served_share",
    "exact_served_share",
)
"""Numbers in which the base is put beside all layouts; more is better."""

BINS = 20
"""Parts into which each span is cut to see what matters."""

DRAWN = 4000
"""Layouts that are drawn, evenly out of all: more would cover each other."""

EQUAL = 1e-9
"""Shares by which numbers may differ and count as equal."""

ROUNDING = 1e-12
"""Share of a sum of squares up to which the variance that is taken from it is rounding."""


@dataclass(kw_only=True)
class StudySummary:
    """All shards of a study, in numbers that do not grow with them.

    Attributes
    ----------
    draws : layouts drawn
    measured : of them that keep to the constraints and have full rank
    refused : the others, by what refused them first
    even : layouts of the study's own round, spread evenly; those of refinement crowd around the best
    comparable : by column of COMPARED, how many of the even ones have that number
    better : by column of COMPARED, how many of those are better than the base
    at_least_as_good : layouts that beat the base in something that counts, and lose in nothing
    best : by column of COMPARED, the largest number of any layout
    front : the Pareto front
    points : (M, 2) authority whole and after the worst failure of layouts to draw
    settings : (M, P) parameters of the even ones of these
    bins : outcome, parameter, part of its span: count, sum and sum of squares of the outcome
    """

    draws: int = 0
    measured: int = 0
    refused: dict[str, int] = field(default_factory=dict)
    even: int = 0
    comparable: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COMPARED, 0))
    better: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COMPARED, 0))
    at_least_as_good: int = 0
    best: dict[str, float] = field(default_factory=lambda: dict.fromkeys(COMPARED, float("-inf")))
    front: "pa.Table | None" = None
    points: list[FloatArray] = field(default_factory=list)
    settings: list[FloatArray] = field(default_factory=list)
    bins: FloatArray = field(default_factory=lambda: np.zeros(0))

    def explained(self) -> FloatArray:
        """(outcomes, parameters) share of an outcome's variance that each parameter alone explains.

        It says nothing of a parameter whose effect another one turns round: see ``changes``. The variance of
        the means over the parts of a span, over that of all layouts (the first-order index of
        Sobol' 1993), less what that many parts explain by chance. What is left is due to parameters together.
        NaN where the outcome is constant but for rounding, or the parameter is, or there are fewer than two
        layouts to a part.
        """
        count, total, squares = np.moveaxis(self.bins, -1, 0)
        n = np.maximum(count.sum(axis=-1), 1)
        mean = total.sum(axis=-1) / n
        within = (squares - np.divide(total**2, count, out=np.zeros_like(total), where=count > 0)).sum(
            axis=-1
        )
        whole = squares.sum(axis=-1) - n * mean**2
        parts = (count > 0).sum(axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = 1 - (within / np.maximum(n - parts, 1)) / (whole / np.maximum(n - 1, 1))
        said = (whole > ROUNDING * squares.sum(axis=-1)) & (parts > 1) & (n >= 2 * parts)
        found: FloatArray = np.where(said, np.clip(share, 0.0, 1.0), np.nan)
        return found

    def chance(self) -> float:
        """The share of ``explained`` below which a parameter can't be told from one without effect.

        Twice the standard deviation of what BINS parts of equal layouts explain by chance,
        2 sqrt(2 (BINS - 1)) / n, with n layouts (variance of a chi-squared number: twice its freedom).
        """
        n = self.bins[..., 0].sum(axis=-1)
        return 2 * sqrt(2 * (BINS - 1)) / float(n[n > 0].min(initial=inf))


CHANGED = 256
"""Layouts of which each parameter is changed, at most: their mean change is known within about 7 %."""


def changes(space: LayoutSpace, said: StudySummary) -> FloatArray:
    """(outcomes, parameters) mean change of an outcome with one parameter alone, over the outcome's mean [-].

    Layouts of the study's own round are measured once more, with one parameter as another of them has it. A
    change that breaks a constraint is left out; NaN where none is left, or where no layout has the number.
    """
    drawn = np.concatenate([*said.settings, np.zeros((0, len(space.parameters)))])
    drawn = np.random.default_rng(0).permutation(drawn)[: 2 * CHANGED]
    count = len(drawn) // 2
    kept, others = drawn[:count].T, drawn[count : 2 * count].T
    whole = _outcomes(space, kept)
    found = np.full((len(OUTCOMES), len(space.parameters)), np.nan)
    for p in range(len(space.parameters)):
        changed = kept.copy()
        changed[p] = others[p]
        change = np.abs(_outcomes(space, changed) - whole)
        for o, known in enumerate(np.isfinite(change)):
            if known.any() and whole[o, known].any():
                found[o, p] = change[o, known].mean() / whole[o, known].mean()
    return found


def _outcomes(space: LayoutSpace, settings: FloatArray) -> FloatArray:
    """(outcomes, B) of layouts with parameters (P, B); NaN where a layout is refused."""
    measured = measure(space, settings)
    found = np.full((len(OUTCOMES), settings.shape[1]), np.nan)
    found[:, measured.places] = [measured.columns[name] for name in OUTCOMES]
    return found


def summarise(space: LayoutSpace, shards: Path, base: Columns) -> StudySummary:
    """Read all shards of a folder, one at a time."""
    said = StudySummary(bins=np.zeros((len(OUTCOMES), len(space.parameters), BINS, 3)))
    paths = [path for _, path in sorted(whole_shards(shards).items())]
    facts = [shard_facts(path) for path in paths]
    said.draws = sum(fact.asked for fact in facts)
    stride = max(said.draws // DRAWN, 1)
    own = _losses_of(base)
    for path, fact in zip(paths, facts, strict=True):
        for reason, count in fact.refused.items():
            said.refused[reason] = said.refused.get(reason, 0) + count
        table = read_shard(path)
        said.measured += table.num_rows
        if table.num_rows:
            _add(said, space.parameters, table, base, own, stride)
    return said


def _losses_of(base: Columns) -> FloatArray:
    import pyarrow as pa

    found: FloatArray = losses(pa.table({name: np.asarray(column) for name, column in base.items()}))[0]
    return found


def _add(
    said: StudySummary,
    parameters: Sequence[Parameter],
    table: "pa.Table",
    base: Columns,
    own: FloatArray,
    stride: int,
) -> None:
    said.front = merged(said.front, table)
    drawn_evenly = table["round"].to_numpy() == 0
    said.even += int(drawn_evenly.sum())
    for name in COMPARED:
        column, least = table[name].to_numpy(), float(base[name][0])
        said.comparable[name] += int((drawn_evenly & ~np.isnan(column)).sum())
        said.better[name] += int((drawn_evenly & (column > least + EQUAL * abs(least))).sum())
        said.best[name] = float(np.fmax(said.best[name], np.fmax.reduce(column)))
    points, room = losses(table), EQUAL * np.abs(own)
    beats = (points <= own + room).all(axis=1) & (points < own - room).any(axis=1)
    said.at_least_as_good += int(beats.sum())
    chosen = table["layout"].to_numpy() % stride == 0
    said.points.append(
        np.array([table["authority"].to_numpy()[chosen], table["authority_after_one"].to_numpy()[chosen]]).T
    )
    settings = [table[parameter.name].to_numpy()[chosen & drawn_evenly] for parameter in parameters]
    said.settings.append(np.array(settings, dtype=float).T)
    for p, parameter in enumerate(parameters):
        share = parameter.share(table[parameter.name].to_numpy().astype(float))
        part = np.minimum((share * BINS).astype(int), BINS - 1)
        for o, outcome in enumerate(OUTCOMES):
            y = table[outcome].to_numpy()
            known = drawn_evenly & ~np.isnan(y)
            for power in range(3):
                said.bins[o, p, :, power] += np.bincount(part[known], y[known] ** power, minlength=BINS)
