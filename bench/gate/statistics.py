"""Ratios of paired times with their intervals; a pair of processes is the sampling unit."""

from collections.abc import Sequence
from math import exp, isfinite, log, sqrt
from statistics import fmean, median, stdev
from typing import NamedTuple

from bench.results.quantiles import CONFIDENCE

Blocks = Sequence[tuple[int, int]]


class Ratio(NamedTuple):
    """How many times longer the head takes than the base.

    Attributes
    ----------
    value : the estimate of head / base [-]
    lower, upper : ends of its 95 % interval [-]
    """

    value: float
    lower: float
    upper: float


def ratio(pairs: Sequence[Blocks]) -> Ratio:
    """R = exp(mean m_p), Student's t on the P values m_p = median over blocks of ln(head / base).

    Blocks within a pair share two processes with their layouts, so they are no samples of their own.
    A single pair says nothing about the spread: its interval is (0, inf).
    """
    m = [median(log(head / base) for base, head in blocks) for blocks in pairs]
    mean = fmean(m)
    if len(m) < 2:
        return Ratio(exp(mean), 0.0, float("inf"))
    from scipy.special import stdtrit  # scipy.stats, which has the whole test, takes a second to import

    half = float(stdtrit(len(m) - 1, (1 + CONFIDENCE) / 2)) * stdev(m) / sqrt(len(m))
    assert isfinite(half)
    return Ratio(exp(mean), exp(mean - half), exp(mean + half))


def medians_us(pairs: Sequence[Blocks], calls: int) -> tuple[float, float]:
    """Median time of a call over all blocks, base and head [µs]."""
    base, head = (median(block[side] for blocks in pairs for block in blocks) for side in (0, 1))
    return base / calls / 1e3, head / calls / 1e3
