"""Statistics of counted times, quantiles, intervals, bounds, and of the repeats of a cell."""

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import accumulate, chain
from math import ceil
from operator import itemgetter
from statistics import median
from typing import Any, NamedTuple, TypeVar

from alloc.vehicle.geometry import DOF, MOMENTS
from bench.record import Batch, Cell, Header, Judged, Key, Method, Problem, Worker

Time = TypeVar("Time", bound=float)
N = TypeVar("N", int, float)
Item = TypeVar("Item")
Name = TypeVar("Name")
Histogram = Sequence[tuple[float, int]]
"""A multiset of times: [(time [ns], how often), …], sorted."""

CONFIDENCE = 0.95
"""Confidence of every interval and bound, here and in the gate."""
BEYOND = 10
"""Fewest calls that must lie beyond a quantile for it to be given."""


@dataclass(frozen=True)
class Tally:
    """Multiset of times with sums that are kept, for counts of late calls at many limits.

    Attributes
    ----------
    times : [(time [ns], how often), …], sorted
    """

    times: Histogram

    @cached_property
    def calls(self) -> int:
        """Number of times."""
        return total(self.times)

    @cached_property
    def took_ns(self) -> float:
        """All times together [ns]."""
        return sum(ns * count for ns, count in self.times)

    @cached_property
    def _tail_counts(self) -> list[int]:
        return [*accumulate((count for _, count in reversed(self.times)), initial=0)][::-1]

    def later(self, limit_us: float, beyond_us: float = 0.0) -> int:
        """Number of times that are longer than a limit, ``beyond_us`` added to each [us]."""
        return self._tail_counts[
            bisect_right(self.times, limit_us, key=lambda each: beyond_us + each[0] / 1000)
        ]


def merge(counted: Iterable[Sequence[tuple[Time, int]]]) -> list[tuple[Time, int]]:
    """Several multisets of times as one."""
    times: dict[Time, int] = {}
    for ns, count in chain.from_iterable(counted):
        times[ns] = times.get(ns, 0) + count
    return sorted(times.items())


def total(counted: Histogram) -> int:
    """Number of times in the multiset."""
    return sum(map(itemgetter(1), counted))


def quantile(counted: Histogram, q: float) -> float | None:
    """The least time [ns] that a share ``q`` of all times does not exceed; None where n(1 - q) < BEYOND."""
    n = total(counted)
    # 10,000 (1 - 0.999) may be 9.99… by rounding and must count as ten; 9.6 must not.
    return time_at_rank(counted, q * n) if n * (1 - q) > BEYOND - 1e-6 else None


def interval(counted: Histogram, q: float) -> tuple[float, float] | None:
    """Bounds [ns] that hold quantile ``q`` with CONFIDENCE, from order statistics; None where it has none.

    The number of calls below the quantile is binomial (n, q), whatever the distribution of times, if calls
    are independent. They are not, and processes differ: ``count_disjoint`` in the report counts how often
    that shows.
    """
    n = total(counted)
    if quantile(counted, q) is None:
        return None
    low, high = _ranks(n, q)
    return time_at_rank(counted, low), time_at_rank(counted, min(high + 1, n))


@cache
def _ranks(n: int, q: float) -> tuple[float, float]:
    """Ends of the interval of a binomial (n, q) count; few different n are asked for, many times."""
    # scipy.stats has this as binom.ppf, and takes longer to import than a report's tables to work out.
    from scipy.special import bdtr, bdtrik

    def least(p: float) -> float:  # the least count that is not exceeded with probability p
        rank = float(ceil(bdtrik(p, n, q)))
        return rank - 1 if rank >= 1 and bdtr(rank - 1, n, q) >= p else rank  # bdtrik rounds

    return least((1 - CONFIDENCE) / 2), least((1 + CONFIDENCE) / 2)


def time_at_rank(counted: Histogram, rank: float) -> float:
    """The time [ns] at this rank, counted from 1 at the fast end, rounded up."""
    below = 0
    for ns, count in counted:
        below += count
        if below >= rank:
            return ns
    return counted[-1][0]


@cache
def late_bound(late: int, n: int) -> float:
    """Upper bound on the share of late calls: that at which so few of n are late with 1 - CONFIDENCE.

    It is Clopper and Pearson's (1934), one-sided, as if calls were independent; about 3 / n if none is late.
    """
    from scipy.special import betaincinv

    return 1.0 if late == n else float(betaincinv(late + 1, n - late, CONFIDENCE))


@cache
def share(hits: int, n: int) -> tuple[float, float, float]:
    """hits / n with its CONFIDENCE interval (Clopper & Pearson 1934): (share, low, high)."""
    from scipy.special import betaincinv

    tail = (1 - CONFIDENCE) / 2
    low = 0.0 if hits == 0 else float(betaincinv(hits, n - hits + 1, tail))
    high = 1.0 if hits == n else float(betaincinv(hits + 1, n - hits, 1 - tail))
    return hits / n, low, high


@dataclass(frozen=True, kw_only=True)
class Repeats:
    """All repeats of a method with its start and level on one vehicle's demand set: the data of a row.

    Attributes
    ----------
    key : the row's name, with repeat 0
    origin : the record's header: machine, versions and options
    described : the method's line of the record
    cells : the repeats, each measured by a process of its own
    workers : the processes that measured them
    disturbances : what disturbed the machine meanwhile, empty where it was quiet
    attainable : share of the set's demands that are labelled inactive or active [-]
    unique : True if the vehicle has no spare thruster, so that each wrench has one solution
    wrong_elsewhere : error of the method's untimed answers on this vehicle, empty for none
    wrong_on_others : error of a plug-in's answers on another of the vehicle's sets, empty for none
    missed_elsewhere : True if these, or those of its twin, miss a demand that the vehicle can meet
    problem : the set's line of the record
    """

    key: Key
    origin: Header
    described: Method
    cells: tuple[Cell, ...]
    workers: tuple[Worker, ...]
    disturbances: tuple[str, ...]
    attainable: float = 0.0
    unique: bool = False
    wrong_elsewhere: str = ""
    wrong_on_others: str = ""
    missed_elsewhere: bool = False
    problem: Problem | None = None

    @cached_property
    def singles(self) -> Histogram:
        """Times of single calls of all repeats together [ns]."""
        return merge(cell.singles for cell in self.cells)

    @cached_property
    def judged(self) -> list[Judged]:
        """Judgements by the equations, one for each repeat that was judged."""
        return [cell.judged for cell in self.cells if cell.judged is not None]

    @cached_property
    def by_repeat(self) -> dict[int, list[float]]:
        """Times of a call in each batch, by repeat [ns]."""
        timed = ((cell.key.repeat, [b.wall_ns / b.calls for b in cell.batches]) for cell in self.cells)
        return {repeat: times for repeat, times in timed if times}

    def centre(self, batches: Callable[[Cell], Sequence[Batch]], clock: str = "wall_ns") -> list[float]:
        """Median time of a call [ns] over the batches of each repeat, one number a repeat."""
        timed = [batches(cell) for cell in self.cells]
        return [median(getattr(b, clock) / b.calls for b in repeat) for repeat in timed if repeat]


class RatioInterval(NamedTuple):
    """Ends of an interval of a ratio of times.

    Attributes
    ----------
    low, high : the ends [-]
    is_confident : True if they hold the ratio with CONFIDENCE; else they are extremes of too few repeats
    """

    low: float
    high: float
    is_confident: bool


def ratio_interval(pairs: Iterable[tuple[Repeats, Repeats]]) -> RatioInterval | None:
    """Interval of the ratio of two methods' times, over the repeats of one run that measured both.

    Each repeat of a pair gives a ratio of medians; the ends are order statistics of these. Where there are
    too few for that, they are slowest over fastest batch of any repeat, and the other way round. None without
    a repeat of both.
    """
    both = [
        (times, two.by_repeat[repeat])
        for one, two in pairs
        for repeat, times in one.by_repeat.items()
        if repeat in two.by_repeat
    ]
    if not both:
        return None
    ratios = sorted(median(one) / median(two) for one, two in both)
    low, high = map(int, _ranks(len(ratios), 0.5))
    if low >= 1 and high < len(ratios):
        return RatioInterval(ratios[low - 1], ratios[high], is_confident=True)
    least, most = (min(min(a) / max(b) for a, b in both), max(max(a) / min(b) for a, b in both))
    return RatioInterval(least, most, is_confident=False)


def group(items: Iterable[Item], key: Callable[[Item], Name]) -> dict[Name, list[Item]]:
    """Items by their key, in the order in which keys first occur."""
    groups: dict[Name, list[Item]] = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return groups


def largest(values: Iterable[N | None]) -> N | None:
    """The largest of the values that are not None; None where all are."""
    return max((value for value in values if value is not None), default=None)


def largest_of_all(values: Iterable[N | None]) -> N | None:
    """The largest of the values; None where one is, for it might be larger."""
    known = list(values)
    return None if None in known else largest(known)


def calls(cell: Cell) -> int:
    """Number of timed calls of a cell; one that was timed both in a batch and singly counts once."""
    batched, singly = sum(batch.calls for batch in cell.batches), total(cell.singles)
    # Slow single calls are stored as batches too. Then batches and singles together hold more time than was
    # timed at all. The bins of the singles are 1 % off at most.
    batches_ns = sum(batch.wall_ns for batch in (*cell.batches, *cell.binding_batches, *cell.way_in_batches))
    singles_ns = sum(ns * count for ns, count in cell.singles)
    twice = batched == singly and cell.timed_ns < batches_ns + 0.98 * singles_ns
    return batched if twice else batched + singly


def tail_ns(measured: Repeats, q: float) -> float | None:
    """Quantile of single calls [ns]; None where batches took longer: then the machine was not the same."""
    tail, median_ns = (
        quantile(measured.singles, q),
        median_or_none(measured.centre(lambda cell: cell.batches)),
    )
    return None if tail is None or (median_ns is not None and tail < median_ns) else tail


def end_ns(measured: Repeats, q: float, end: int) -> float | None:
    """Lower (0) or upper (1) end [ns] of the interval of ``tail_ns``; None where that is None."""
    bounds = None if tail_ns(measured, q) is None else interval(measured.singles, q)
    return None if bounds is None else bounds[end]


def microseconds(ns: float | None) -> float | None:
    """The time in µs."""
    return None if ns is None else ns / 1000


def median_or_none(values: list[float]) -> float | None:
    """The median; None for an empty list."""
    return median(values) if values else None


class Worst(cached_property[float | None]):
    """A column with the worst number of the judgements of a row's repeats, None where none has it.

    Without ``of`` it is the loss that has the column's name.
    """

    def __init__(
        self,
        meaning: str,
        of: Callable[[Judged], float | None] | None = None,
        worst: Callable[[list[float]], float] = max,
    ) -> None:
        """Make a column from its documentation, the number of one judgement, and the order of badness."""

        def column(row: Any) -> float | None:
            numbers = (of(judged) if of else judged.loss.get(self.name) for judged in row.measured.judged)
            known = [number for number in numbers if number is not None]
            return worst(known) if known else None

        column.__doc__ = meaning
        self.of = of
        super().__init__(column)

    def __set_name__(self, owner: type[Any], name: str) -> None:
        super().__set_name__(owner, name)
        self.name = name


def by_level(repeats: list[list[float]], of: Callable[[list[float]], float]) -> str:
    """One number of each level of a demand, over the repeats, in a cell; empty without levels."""
    levels = zip(*(shares for shares in repeats if shares), strict=True)
    return " ".join(f"{of(list(shares)):.6g}" for shares in levels)


def worst_axis(judged: Judged, moments: bool) -> float | None:
    """Largest |delivered - tau| on any force axis [N], or on any moment axis [N m]."""
    suffix = "max_Nm" if moments else "max_N"
    axes = [axis for axis in DOF if (axis in MOMENTS) == moments]
    return largest(judged.loss.get(f"wrench_error_{axis}_{suffix}") for axis in axes)
