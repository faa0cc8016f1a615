"""Statistics of counted times, worked out when a record is read: quantiles, intervals, bounds."""

from collections.abc import Iterable
from itertools import chain

Histogram = list[tuple[int, int]]
"""A multiset of times: [(ns, how often), …], sorted."""

CONFIDENCE = 0.95
"""Of every interval and bound, here and in the gate."""
BEYOND = 10
"""A quantile is given only where this many calls lie beyond it; below that it is an anecdote."""


def merged(counted: Iterable[Histogram]) -> Histogram:
    """Several multisets of times as one."""
    times: dict[int, int] = {}
    for ns, count in chain.from_iterable(counted):
        times[ns] = times.get(ns, 0) + count
    return sorted(times.items())


def total(counted: Histogram) -> int:
    """How many times there are."""
    return sum(count for _, count in counted)


def quantile(counted: Histogram, q: float) -> int | None:
    """The least time [ns] that a share ``q`` of all does not exceed; None where n(1 - q) < BEYOND."""
    n = total(counted)
    # 10,000 (1 - 0.999) is 10.000000000000009 or 9.99…, as rounding has it; 9.6 is not ten.
    return ranked(counted, q * n) if n * (1 - q) > BEYOND - 1e-6 else None


def interval(counted: Histogram, q: float) -> tuple[int, int] | None:
    """Bounds [ns] that hold quantile ``q`` with CONFIDENCE, from order statistics; None as ``quantile``.

    The number of calls below the quantile is binomial (n, q), whatever the distribution of times, if calls
    are independent. They are not, and processes differ: ``bench.report.tails.unmet`` counts how it shows.
    """
    from scipy.stats import binom

    n = total(counted)
    if quantile(counted, q) is None:
        return None
    low, high = (float(binom.ppf(p, n, q)) for p in ((1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2))
    return ranked(counted, low), ranked(counted, min(high + 1, n))


def ranked(counted: Histogram, rank: float) -> int:
    """The time [ns] at this rank, counted from 1 at the fast end, rounded up."""
    below = 0
    for ns, count in counted:
        below += count
        if below >= rank:
            return ns
    return counted[-1][0]


def misses(counted: Histogram, deadline_ns: float) -> tuple[int, int, float]:
    """Calls later than a deadline, of how many, and the share that is not exceeded with CONFIDENCE.

    The bound is Clopper and Pearson's (1934), one-sided, as if calls were independent; without a miss it is
    about 3 / n.
    """
    from scipy.stats import binomtest

    n = total(counted)
    late = sum(count for ns, count in counted if ns > deadline_ns)
    bound = binomtest(late, n, alternative="less").proportion_ci(CONFIDENCE, method="exact").high
    return late, n, float(bound)


def share(hits: int, n: int) -> tuple[float, float, float]:
    """hits / n with its CONFIDENCE interval (Clopper & Pearson 1934): (share, low, high)."""
    from scipy.stats import binomtest

    ends = binomtest(hits, n).proportion_ci(CONFIDENCE, method="exact")
    return hits / n, float(ends.low), float(ends.high)
