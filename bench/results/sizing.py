"""Fit of methods to a control rate: times, late calls, and a verdict."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import inf
from operator import itemgetter
from statistics import fmean

from bench.record import NO_VEHICLE, SERVED_WITHIN, Problem
from bench.results.columns import Row
from bench.results.fit import LATE_SHARE, Fit, Loop
from bench.results.pauses import Pauses, pauses, whose
from bench.results.quantiles import Histogram, Tally, late_bound, merged, quantile, total
from bench.results.ranking import exact, largest_miss
from bench.results.repeats import most_of_all
from bench.results.rows import Run
from bench.results.size import Size, ordered
from bench.results.transfer import Transfer
from bench.results.unfit import MISSES, refusal, refuses, unfit


def sizes(run: Run, loop: Loop, transfer: Transfer | None = None, demands: str = "") -> list[Size]:
    """Every method, start and level of a run, ``ordered``; on all demand sets, or on one.

    With a ``transfer`` every time is multiplied by the upper end of its band. A slowest call belongs to the
    machine that made it and is not transferred.
    """
    groups = [
        own for rows in of_methods(run) if (own := [row for row in rows if demands in ("", row.demands)])
    ]
    return ordered([pool.size(loop) for pool in pools(run, groups, transfer)])


def of_methods(run: Run) -> list[list[Row]]:
    """The rows of each method, start and level on each vehicle."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in run.rows:
        if not row.described.yardstick and row.vehicle != NO_VEHICLE:
            groups.setdefault((row.vehicle, row.label), []).append(row)
    return list(groups.values())


def pools(run: Run, groups: Iterable[Sequence[Row]], transfer: Transfer | None = None) -> Iterator["Pool"]:
    """Pools of each method; a group holds its rows on all demand sets, or on some."""
    held_up = pauses(run)
    for rows in groups:
        yield _pool(rows, transfer, held_up, run.asked)


@dataclass(frozen=True)
class Pool:
    """Measured times of one method, start and level on some demand sets: its size, but for the loop.

    Attributes
    ----------
    seen : all of the size that no loop changes; with a reason it is unfit for any
    singles : single calls on all the sets, [(time [ns], how often), …], sorted
    pauses : of fixed work in the same run; None where times are estimated for another machine
    """

    seen: Size
    singles: Histogram
    pauses: Pauses | None

    @cached_property
    def _tally(self) -> Tally:
        return Tally(self.singles)

    def size(self, loop: Loop) -> Size:
        """The size in a loop."""
        seen = self.seen
        if seen.reason:
            return seen
        late, bound = self.late(loop.limit_us)
        fit, reason, machines = self.verdict(loop.limit_us)
        rate = loop.highest_rate_hz(seen.max_us) if seen.max_us else None
        return replace(seen, fit=fit, reason=reason, late=late, bound=bound, machines=machines, rate_hz=rate)

    def late(self, limit_us: float) -> tuple[int, float | None]:
        """Number of calls later than a limit, and the bound on their share: None without calls."""
        late = self._tally.later(limit_us)
        return late, late_bound(late, self.seen.calls) if self.seen.calls else None

    def verdict(self, limit_us: float) -> tuple[Fit, str, bool]:
        """Fit of calls to a limit, why not better, and whether late calls were the machine's doing."""
        seen, (late, bound) = self.seen, self.late(limit_us)
        excuse = ""
        if self.pauses and seen.p50_us is not None:
            excuse = whose(self._tally, late, limit_us, seen.p50_us, seen.steps, self.pauses)
        if excuse:  # an excused call counts as if it had not been late
            fit, reason = judge(limit_us, seen.p50_us, None, None, late_bound(0, seen.calls))
        else:
            fit, reason = judge(
                limit_us, seen.p50_us, seen.p999_us, seen.max_us, bound, estimated=self.pauses is None
            )
        return fit, reason or excuse, bool(excuse)

    def verdicts(self) -> list[tuple[float, Fit, str]]:
        """Every verdict, with the limit [us] from which it holds, up to that of the next."""
        p50 = self.seen.p50_us
        if self.seen.reason:
            return [(0.0, self.seen.fit, self.seen.reason)]
        if p50 is None:
            return [(0.0, *self.verdict(0.0)[:2])]
        shown = [p50, self.seen.p999_us, self.seen.max_us, p50 * (self.seen.steps or 0)]
        times = {time for time in [*shown, *(ns / 1000 for ns, _ in self.singles)] if time and time >= p50}
        excess = [p50 + ns / 1000 for ns, _ in self.pauses.excess] if self.pauses else []
        limits = {0.0: self.verdict(0.0)}
        for limit, until in pairwise([*sorted(times), inf]):
            limits[limit] = first = self.verdict(limit)
            if first[2]:  # the longer a call, the fewer pauses were as long: excuses end at some limit
                between = excess[bisect_right(excess, limit) : bisect_left(excess, until)]
                at = bisect_left(between, True, key=lambda us: self.verdict(us) != first)
                limits.update((us, self.verdict(us)) for us in between[at : at + 1])
        found: list[tuple[float, Fit, str]] = []
        for us, (fit, reason, _) in limits.items():
            if not found or found[-1][1:] != (fit, reason):
                found.append((us, fit, reason))
        return found


def _pool(
    rows: Sequence[Row], transfer: Transfer | None, held_up: Pauses, asked: Mapping[tuple[str, str], Problem]
) -> Pool:
    first = rows[0]
    problem = asked.get((first.vehicle, first.demands))
    size = Size(
        vehicle=first.vehicle,
        method=first.method,
        label=first.label,
        twin=first.described.twin,
        family=first.family,
        solver=first.described.solver,
        formulation=first.formulation,
        unlimited=first.unlimited,
        freedom=problem.nullity if problem else None,
        fit=Fit.UNKNOWN,
        reason=unfit(rows),
    )
    if size.reason:
        return Pool(size, [], None)
    factor = transfer.high if transfer else 1.0
    singles = [(ns * factor, count) for ns, count in merged(row.measured.singles for row in rows)]
    p50 = _times(factor, most_of_all(row.call_p50_us for row in rows))
    tail = quantile(singles, 0.999)
    problems = [asked.get((row.vehicle, row.demands)) for row in rows]
    known = [each for each in problems if each]
    moving = any(p.moving and p.given for p in known) or (bool(known) and all(p.moving for p in known))
    refusals = [refusal(row, each) for row, each in zip(rows, problems, strict=True)]
    refused, words = max((found for found in refusals if found[1]), key=itemgetter(0), default=(0.0, ""))
    size = replace(
        size,
        exact=exact_everywhere(rows),
        missing=missing(rows),
        refused=refused,
        refusal=words,
        moving=moving,
        picky=refuses(first.formulation) and words not in MISSES,
        p50_us=p50,
        p999_us=None if tail is None or p50 is None or tail / 1000 < p50 else tail / 1000,
        max_us=None if transfer or not singles else singles[-1][0] / 1000,
        calls=total(singles),
        cpu_us=_times(factor, most_of_all(row.call_cpu_p50_us for row in rows)),
        memory_MB=most_of_all(row.peak_rss_MB for row in rows),
        steps=first.worst_case_steps,
    )
    return Pool(size, singles, None if transfer else held_up)


def exact_everywhere(rows: Sequence[Row]) -> bool:
    """True if a method is exact on all of these rows that ask attainable demands, and there is one."""
    # On a set without attainable demands an exact method may have no answers to be judged by.
    asked = [row for row in rows if row.measured.attainable or row.agreed is not None]
    return all(exact(row) for row in asked) and any(exact(row) for row in rows)


def missing(rows: Sequence[Row]) -> float:
    """The share of the demands that can be met of which more than SERVED_WITHIN is left out, a mean of sets.

    0 where none is. What is delivered within SERVED_WITHIN counts demands just beyond the limits too, and
    these may hide one that is left out: where any is, the share is SERVED_WITHIN at least.
    """
    if (largest_miss(rows) or 0.0) <= SERVED_WITHIN:
        return 0.0
    known = [(row.within_1pct_share, row.measured.attainable) for row in rows]
    served = [min(within / can, 1.0) for within, can in known if within is not None and can > 0]
    return max(1.0 - fmean(served), SERVED_WITHIN) if served else 1.0


def judge(
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


def _times(factor: float, us: float | None) -> float | None:
    return None if us is None else factor * us
