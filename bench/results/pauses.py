"""Late calls of the method and of the machine, told apart by fixed work in the same run."""

from dataclasses import dataclass
from functools import cached_property

from bench.record import NO_VEHICLE
from bench.results.fit import LATE_SHARE
from bench.results.quantiles import Histogram, Tally, merged, ranked, total
from bench.results.rows import Run

CHANCE = 1e-3
"""Probability below which as many late calls are no chance, were they the machine's. A run sizes hundreds of
methods, and pauses come in bursts, so one in twenty would blame a method in every run."""


@dataclass(frozen=True)
class Pauses:
    """By how much fixed work (``noop`` and the canaries) took longer than its own median.

    Attributes
    ----------
    excess : [(time beyond the median [ns], how often), …] of all calls beyond it, sorted
    exposure_ns : time of all calls of fixed work together [ns]
    """

    excess: Histogram
    exposure_ns: float

    def late(self, limit_us: float, p50_us: float) -> int:
        """How many of them would have made a call late that takes ``p50_us`` [us]."""
        return self._tally.later(limit_us, p50_us)

    @cached_property
    def _tally(self) -> Tally:
        return Tally(self.excess)


def pauses(run: Run) -> Pauses:
    """The pauses that a run's yardsticks show."""
    excess: list[Histogram] = []
    exposure = 0.0
    for row in run.rows:
        # NAME_esc on a board allocates nothing either, but is asked this and that: its work is not fixed.
        fixed = row.described.yardstick and not row.measured.cells[0].worst
        if row.measured.singles and (fixed or row.vehicle == NO_VEHICLE):
            median = ranked(row.measured.singles, total(row.measured.singles) / 2)
            excess.append([(ns - median, count) for ns, count in row.measured.singles if ns > median])
            exposure += sum(ns * count for ns, count in row.measured.singles)
    return Pauses(merged(excess), exposure)


def whose(
    singles: Tally, late: int, limit_us: float, p50_us: float, steps: int | None, pauses: Pauses
) -> str:
    """Why the late calls are the machine's, in words; empty where they may be the method's own.

    They are the machine's where the method's ``steps`` are bounded, and either all of them fit the limit even
    if each took as long as a median call, or just one call was late: the same demands were asked many times.
    Else they are the machine's where they are rare, at most LATE_SHARE of all, and fixed work was held up as
    long, as often in the time that it took: of all pauses that long, binomially as many hit the method as its
    calls' share of the time, and this many or more have at least the probability CHANCE. Without one such
    pause of fixed work nothing is excused.
    """
    from scipy.special import betainc

    if not late:
        return ""
    if steps and (late == 1 or steps * p50_us <= limit_us):
        return "its steps are bounded, so the machine was late"
    if late > LATE_SHARE * singles.calls or not (seen := pauses.late(limit_us, p50_us)):
        return ""
    share = singles.took_ns / (singles.took_ns + pauses.exposure_ns)
    return (
        "fixed work was late as often, so the machine was" if betainc(late, seen + 1, share) >= CHANCE else ""
    )
