"""The bins that a record counts single calls in."""

from functools import cache
from math import log

BIN = 1.02
"""Bins are 2 % wide, so a time is at most 1 % off; the median of single calls repeats only within 1-3 %
(docs/method.md). Counting in bins keeps a run's record small enough to be committed."""


@cache
def binned(ns: int) -> int:
    """The middle of the bin that ``ns`` falls into [ns]: the nearest power of BIN, as a whole number."""
    return ns if ns < 1 else round(BIN ** round(log(ns) / log(BIN)))
