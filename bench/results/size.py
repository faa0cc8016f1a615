"""Size of a method: its share of a control loop, the verdict, and the order of advice."""

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import groupby
from math import sqrt
from operator import attrgetter
from typing import Any, NamedTuple

from bench.record import SERVED_WITHIN
from bench.results.quantiles import largest, largest_of_all

LATE_SHARE = 0.001
"""Largest share of late calls of a method that fits: one in a thousand, as p99.9 is judged."""


class Fit(IntEnum):
    """Verdict on a method's time against the time it may take, best first."""

    FITS = 0
    WITHOUT_TAIL = 1
    """The median fits; the tail does not, or is not known."""
    MAY_FIT = 2
    """Only a band is known for the time, and the limit lies inside the band."""
    DOES_NOT_FIT = 3
    UNKNOWN = 4

    def __str__(self) -> str:
        """The verdict in words."""
        return ("fits", "median fits", "may fit", "does not fit", "unknown")[self]


@dataclass(frozen=True)
class Loop:
    """A control loop that a method must serve.

    Attributes
    ----------
    rate_hz : calls per second [Hz]
    budget : share of the period that allocation may take [-]
    deadline_us : time that allocation may take [us], in place of a budget
    """

    rate_hz: float
    budget: float = 0.1
    deadline_us: float | None = None

    @property
    def period_us(self) -> float:
        """Time from one call to the next [us]."""
        return 1e6 / self.rate_hz

    @property
    def limit_us(self) -> float:
        """Time that one call may take [us]."""
        return self.budget * self.period_us if self.deadline_us is None else self.deadline_us

    @property
    def limit_share(self) -> float:
        """Share of the period that one call may take [-]."""
        return self.limit_us / self.period_us

    def highest_rate_hz(self, call_us: float) -> float:
        """Highest rate [Hz] at which a call of ``call_us`` [us] keeps within the budget, or the period."""
        return (self.budget if self.deadline_us is None else 1.0) * 1e6 / call_us


def judge_times(
    limit_us: float,
    p50_us: float | None,
    p999_us: float | None,
    max_us: float | None,
    bound: float | None,
    estimated: bool = False,
) -> tuple[Fit, str]:
    """Verdict on a method's times, and what prevents a better one, empty where nothing does.

    A method ``fits`` where no call was late, of so many that at most LATE_SHARE of all calls are late with
    95 % confidence; that takes 2,995 calls. It ``fits without tail`` where the median fits, and the tail does
    not or is not known. It ``does not fit`` where the median does not, and is ``unknown`` without a median.
    """
    if p50_us is None:
        return Fit.UNKNOWN, "no call was timed"
    if p50_us > limit_us:
        return Fit.DOES_NOT_FIT, "median"
    if p999_us is not None and p999_us > limit_us:
        return Fit.WITHOUT_TAIL, "p99.9"
    if estimated:
        return Fit.WITHOUT_TAIL, "estimate"
    if max_us is not None and max_us > limit_us:
        return Fit.WITHOUT_TAIL, "slowest call"
    if bound is None or bound > LATE_SHARE:
        return Fit.WITHOUT_TAIL, "too few calls"
    return Fit.FITS, ""


CLOSE = 1.5
"""Median CPU times within this factor count as equal: noise swaps them from run to run."""
EDGES = (SERVED_WITHIN * (1 - 1e-9), *(tenth / 10 for tenth in range(1, 10)))
"""The most missing of each number of ``tenths`` [-]."""
SPARE = 0.01
"""Share of the period below which a difference of medians decides nothing [-]: the loop has that time."""


class Precedence(NamedTuple):
    """Place of a method in advice: the least ``usefulness`` first, then the median, then the ``place``.

    Attributes
    ----------
    usefulness : in turn: whether its median fits, whether it answers every demand that was asked, whether it
        is exact or how many tenths it misses (as many count as equal), and whether its tail is surely late.
        So exactness is given up only where no exact method keeps up and answers all; without one, a rule
        that delivers less is not taken for microseconds that the loop has. A tail that few calls leave open
        decides nothing, for how many there are depends on the machine.
    median_us : median CPU time, else by the clock [us]
    place : among medians that count as equal, by what no clock measures. In turn: whether it answers what
        another dive may ask, keeps the limits, has a known worst case, is C of the vehicle's own (the
        costliest call of a library for all may take forty times as long, where its median is as short),
        needs no QP solver, how much it misses, and the shorter name.
    """

    usefulness: tuple[int, ...]
    median_us: float
    place: tuple[Any, ...]

    @staticmethod
    def close(least_us: float, period_us: float) -> float:
        """The median that counts as equal to the least [us]: within CLOSE, or SPARE of the period."""
        return max(CLOSE * least_us, least_us + SPARE * period_us)


@dataclass(frozen=True, kw_only=True)
class Size:
    """One method, with its start and level, on one vehicle over all its demand sets, or one of them.

    Attributes
    ----------
    vehicle, method, label : what was sized; the label is method, start and level
    twin, family, solver, formulation : of the method, as the record describes it
    unlimited : whether thrusts may lie beyond the limits
    fit : the verdict
    reason : what prevents a better ``fit``, or why late calls do not; empty where nothing does
    exact : whether it is exact wherever an attainable demand was asked
    refused : share of a log or a mission that got no thrusts [-], of several the largest;
        1 where something that can be met was not delivered at all
    refusal : that, or what else it refuses, in words; empty where it answers all
    part : in words, how much of a mission was asked where that is not all of it; else empty
    missing : share of the demands that can be met of which it leaves out more than SERVED_WITHIN [-]
    missing_low, missing_high : ends of the 95 % interval of ``missing`` [-]; equal where it is exact
    n_even : number of demands drawn evenly that ``missing`` is a share of, the same for each method; 0 where
        other sets have a part in it
    misses : a bit for each demand drawn evenly that it leaves out; empty where that is not known
    unanswered : whether some demand that was asked, drawn or of a log, got no thrusts within the limits, or a
        wrench of nothing
    other_gap : the ``gap`` that more demands drawn evenly may show; None where these leave no doubt
    picky : whether it refuses what can't be met, and delivers what can
    moving : whether a log's calls, or all, had limits of their own: C for these takes ``--limits call``
    freedom : n - rank T of the vehicle, None where it is not known
    p50_us : median on the demand set that takes longest [us], None where there are too few calls
    p999_us, max_us : p99.9 and the slowest of the single calls on all sets together [us], or None; a set with
        so few calls that its median lies above such a p99.9 leaves it unknown
    late, calls : number of late single calls, and of all single calls
    bound : share of late calls that is not exceeded with 95 % confidence [-]
    machines : whether the late calls were the machine's, not the method's
    often : whether surely more than LATE_SHARE of all calls are late, by the method's doing
    cpu_us : like ``p50_us`` in the thread's own CPU time, which a busy machine disturbs less [us]
    rate_hz : highest rate that the slowest call seen allows [Hz]
    memory_MB : peak memory of the method's process [MB]
    steps : proven bound on the steps of a call, None for none
    """

    vehicle: str
    method: str
    label: str
    twin: str = ""
    family: str = ""
    solver: str = ""
    formulation: str = ""
    unlimited: bool = False
    fit: Fit
    reason: str
    exact: bool = False
    refused: float = 0.0
    refusal: str = ""
    part: str = ""
    missing: float = 0.0
    missing_low: float = 0.0
    missing_high: float = 0.0
    n_even: int = 0
    misses: bytes = b""
    unanswered: bool = False
    other_gap: int | None = None
    picky: bool = False
    moving: bool = False
    freedom: int | None = None
    p50_us: float | None = None
    p999_us: float | None = None
    max_us: float | None = None
    late: int = 0
    calls: int = 0
    bound: float | None = None
    machines: bool = False
    often: bool = False
    cpu_us: float | None = None
    rate_hz: float | None = None
    memory_MB: float | None = None
    steps: int | None = None

    @property
    def gap(self) -> int:
        """Kind of demands without thrusts: 0 for none, 1 for some that were drawn, 2 for some of a log."""
        return 2 if self.refused > 0 else int(self.unanswered)

    @property
    def precedence(self) -> Precedence:
        """Place in advice."""
        return self.precedence_if(self.fit, self.gap, self.missing, self.often, self.median_us)

    def precedence_if(self, fit: Fit, gap: int, missing: float, often: bool, median_us: float) -> Precedence:
        """``precedence`` with these in place of its own."""
        # What is less than SERVED_WITHIN counts as none: how many demands were asked would decide.
        tenths = bisect_left(EDGES, missing)
        tail = int(often) if fit <= Fit.WITHOUT_TAIL else int(fit) - 1
        facts = (self.picky, self.unlimited, self.steps is None, not self.twin, bool(self.solver))
        place = (*facts, missing if tenths else 0.0, len(self.method), self.method, median_us, self.label)
        return Precedence((fit > Fit.MAY_FIT, gap, not self.exact, tenths, tail), median_us, place)

    @property
    def median_us(self) -> float:
        """Median CPU time, else by the clock [us]; 0 without either."""
        return self.p50_us or 0.0 if self.cpu_us is None else self.cpu_us


def rank_sizes(sizes: Sequence[Size], period_us: float) -> list[Size]:
    """Sizes by vehicle, the one to take first: by ``precedence``, for a control period [us]."""
    ranked: list[Size] = []
    placed = sorted(((s.vehicle, s.precedence, s) for s in sizes), key=lambda own: (own[0], *own[1][:2]))
    for _, alike in groupby(placed, key=lambda own: (own[0], own[1].usefulness)):
        left = list(alike)
        while left:
            equal = Precedence.close(left[0][1].median_us, period_us)
            close = [own for own in left if own[1].median_us <= equal]
            ranked += [size for *_, size in sorted(close, key=lambda own: own[1].place)]
            left = left[len(close) :]
    return ranked


CERTAIN = 1.96
"""Standard deviations of a normal number that 95 % of them keep within."""


def most_missing(size: Size, rival: Size, missing: float) -> float:
    """The most that a size may miss [-] where its rival misses so much.

    Both answered the same demands, so only those count of which one missed what the other did not, b and c:
    the difference is at most b - c + CERTAIN sqrt(b + c) + 1 of them: McNemar's test, Edwards' correction.
    Where there are none, they miss alike. Where the demands are not known, both are read for themselves.
    """
    n, alike, margin = min(size.n_even, rival.n_even), size.missing == rival.missing == 0, 0.0
    if size.misses and len(size.misses) == len(rival.misses):
        differ = (int.from_bytes(size.misses) ^ int.from_bytes(rival.misses)).bit_count()
        alike = alike or not differ
        margin = (CERTAIN * sqrt(differ) + 1) / n if differ and n else 0.0
    if size.exact or not (alike or margin):
        return size.missing_high
    return min(max(missing + (size.missing - rival.missing + margin), 0.0), 1.0)


def _reading(size: Size, loop: Loop, missing: float, *, better: bool) -> Precedence:
    """A size's precedence at the better or the worse end of what noise leaves open, and so much missing."""
    factor = (1 / CLOSE if better else CLOSE) if size.calls else 1.0
    gap = (min if better else max)(size.gap, size.gap if size.other_gap is None else size.other_gap)
    fit = size.fit
    if size.p50_us is not None and fit in (Fit.FITS, Fit.WITHOUT_TAIL, Fit.DOES_NOT_FIT):
        if factor * size.p50_us > loop.limit_us:
            fit = Fit.DOES_NOT_FIT
        elif fit == Fit.DOES_NOT_FIT:
            fit = Fit.WITHOUT_TAIL
    return size.precedence_if(fit, gap, missing, size.often and not better, factor * size.median_us)


def possible_first(ranked: Sequence[Size], loop: Loop) -> Size | None:
    """The size that a longer run may put first in place of the first; None where the first is decided.

    So it is where each other, at the better end of its medians, within CLOSE, stays behind the first with all
    the rest at the worse end; the rival misses what its interval holds, the others ``most_missing`` then.
    """
    floor_us = min((size.median_us for size in ranked), default=0.0)
    for rival in ranked[1:]:
        low, high = rival.missing_low, rival.missing_high
        for missing in sorted({low, rival.missing, high, *(edge for edge in EDGES if low < edge < high)}):
            best = _reading(rival, loop, missing, better=True)
            worse = (
                _reading(size, loop, most_missing(size, rival, missing), better=False)
                for size in ranked
                if size is not rival
            )
            first = next(worse)
            if best.usefulness[:3] > first.usefulness[:3]:  # whatever is missing
                break
            # Where it counts as equal whatever the least median is, the first stays so: the rest takes time.
            equal = Precedence.close(min(floor_us, best.median_us), loop.period_us)
            if first.usefulness < best.usefulness or (
                first.usefulness == best.usefulness and first.median_us <= equal and first.place < best.place
            ):
                continue
            alike = [own for own in (best, first, *worse) if own.usefulness <= best.usefulness]
            equal = Precedence.close(min(own.median_us for own in alike), loop.period_us)
            if all(own.usefulness == best.usefulness for own in alike) and best.place == min(
                own.place for own in alike if own.median_us <= equal
            ):
                return rival
    return None


def second_size(ranked: Sequence[Size]) -> Size | None:
    """Second choice, by the rule of the first: the next that is as useful, and refuses no more; else None."""
    others = _others(ranked)
    return (
        others[0] if others and others[0].precedence.usefulness == ranked[0].precedence.usefulness else None
    )


def possible_second(ranked: Sequence[Size], loop: Loop) -> Size | None:
    """The size that a longer run may name second where there is a second; None where that is decided."""
    return possible_first(_others(ranked), loop) if second_size(ranked) else None


def _others(ranked: Sequence[Size]) -> list[Size]:
    first = ranked[0]
    return [s for s in ranked[1:] if s.method != first.twin and (first.refusal or not s.refusal)]


def best_of_each(sizes: list[Size]) -> list[Size]:
    """The first start and level of each method on each vehicle."""
    first: dict[tuple[str, str], Size] = {}
    for size in sizes:
        first.setdefault((size.vehicle, size.method), size)
    return list(first.values())


def worst_size(there: Mapping[str, Size]) -> Size:
    """Worst of one method's sizes in several places, by name: machines, or vehicles."""
    place, size = max(there.items(), key=lambda item: item[1].fit)
    every = there.values()
    alike = len({s.misses for s in every}) == 1
    numbers: dict[str, Any] = {
        name: largest(map(attrgetter(name), every))
        for name in (
            *("missing", "missing_low", "missing_high", "moving", "refused", "unanswered", "other_gap"),
            *("picky", "often", "p50_us", "max_us", "cpu_us", "bound", "memory_MB"),
        )
    }
    return replace(
        size,
        **numbers,
        reason=f"{place}: {size.reason}" if size.reason else "",
        n_even=min(s.n_even for s in every),
        misses=size.misses if alike else b"",
        exact=all(s.exact for s in every),
        refusal=max(every, key=lambda s: (s.refused, s.refusal)).refusal,
        p999_us=largest_of_all(s.p999_us for s in every),
        late=sum(s.late for s in every),
        calls=sum(s.calls for s in every),
        rate_hz=min((s.rate_hz for s in every if s.rate_hz is not None), default=None),
    )


def rank_labels(sizes: Sequence[Size], period_us: float) -> list[str]:
    """The labels of all methods by their worst on any vehicle, the most useful first."""
    by_label: dict[str, dict[str, Size]] = {}
    for size in sizes:
        by_label.setdefault(size.label, {})[size.vehicle] = size
    worst = [replace(worst_size(own), vehicle="") for own in by_label.values()]
    return [size.label for size in rank_sizes(worst, period_us)]
