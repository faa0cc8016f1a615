"""Statistics of counted times: quantiles, intervals, bounds."""

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import accumulate, chain
from math import ceil
from operator import itemgetter
from typing import TypeVar

Time = TypeVar("Time", bound=float)
Histogram = Sequence[tuple[float, int]]
"""A multiset of times: [(time [ns], how often), …], sorted."""

CONFIDENCE = 0.95
"""Confidence of every interval and bound, here and in the gate."""
BEYOND = 10
"""Fewest calls that must lie beyond a quantile for it to be given."""


@dataclass(frozen=True)
class Tally:
    """A multiset of times that is asked for many limits: its sums are made once.

    Attributes
    ----------
    counted : the times
    """

    counted: Histogram

    @cached_property
    def calls(self) -> int:
        """Number of times."""
        return total(self.counted)

    @cached_property
    def took_ns(self) -> float:
        """All times together [ns]."""
        return sum(ns * count for ns, count in self.counted)

    @cached_property
    def _from(self) -> list[int]:
        return [*accumulate((count for _, count in reversed(self.counted)), initial=0)][::-1]

    def later(self, limit_us: float, beyond_us: float = 0.0) -> int:
        """How many times are longer than a limit, ``beyond_us`` added to each [us]."""
        return self._from[bisect_right(self.counted, limit_us, key=lambda each: beyond_us + each[0] / 1000)]


def merged(counted: Iterable[Sequence[tuple[Time, int]]]) -> list[tuple[Time, int]]:
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
    return ranked(counted, q * n) if n * (1 - q) > BEYOND - 1e-6 else None


def interval(counted: Histogram, q: float) -> tuple[float, float] | None:
    """Bounds [ns] that hold quantile ``q`` with CONFIDENCE, from order statistics; None where it has none.

    The number of calls below the quantile is binomial (n, q), whatever the distribution of times, if calls
    are independent. They are not, and processes differ: ``bench.report.sections.tails.unmet`` counts how
    often that shows.
    """
    n = total(counted)
    if quantile(counted, q) is None:
        return None
    low, high = _ranks(n, q)
    return ranked(counted, low), ranked(counted, min(high + 1, n))


@cache
def _ranks(n: int, q: float) -> tuple[float, float]:
    """Ends of the interval of a binomial (n, q) count; few different n are asked for, many times."""
    # scipy.stats has this as binom.ppf, and takes longer to import than a report's tables to work out.
    from scipy.special import bdtr, bdtrik

    def least(p: float) -> float:  # the least count that is not exceeded with probability p
        rank = float(ceil(bdtrik(p, n, q)))
        return rank - 1 if rank >= 1 and bdtr(rank - 1, n, q) >= p else rank  # bdtrik rounds

    return least((1 - CONFIDENCE) / 2), least((1 + CONFIDENCE) / 2)


def ranked(counted: Histogram, rank: float) -> float:
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
