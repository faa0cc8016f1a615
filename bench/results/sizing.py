"""Fit of methods to a control rate: times, late calls, refusals, and a verdict."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import prod
from statistics import fmean

from bench.record import NO_VEHICLE, SERVED_WITHIN, Problem, Served
from bench.record.file import CanaryError, CanaryFile
from bench.results.columns import Row
from bench.results.quantiles import (
    Histogram,
    Tally,
    largest_of_all,
    late_bound,
    merge,
    quantile,
    share,
    time_at_rank,
    total,
)
from bench.results.ranking import is_exact, is_right, largest_miss, objection
from bench.results.refusals import (
    MISSES,
    NONE,
    even_refusal,
    is_even_refusal_open,
    is_random,
    refusal,
    refuses,
)
from bench.results.rows import Run, served_count
from bench.results.size import LATE_SHARE, Fit, Loop, Size, judge_times, rank_sizes


def unfit_reason(rows: Sequence[Row]) -> str:
    """Reason why a method on these rows has no time at all: not measured, or wrong; else empty."""
    for row in rows:
        if row.failed:
            return f"{row.demands}: {row.failed.status}, {row.failed.reason}"
    for row in rows:
        if reason := wrong_reason(row):
            return reason
    return ""


def wrong_reason(row: Row) -> str:
    """Reason why a row's answers rule out a verdict on its time; empty where they are right, or none."""
    if row.failed or is_right(row):
        return ""
    return f"a wrong answer has no time; {row.demands}: {objection(row)}"


WIDENING = 1.5
"""Factor by which the band is wider at either end than the canaries' ratios. The canaries are a Python loop
and a matrix product; a solver's code also depends on caches, compilers and instruction sets."""


@dataclass(frozen=True)
class Transfer:
    """Time of calls on the target over that on the run's machine.

    Attributes
    ----------
    low, high : ends of the band [-]
    centre : geometric mean of the canaries' ratios [-]
    machine : the target
    """

    low: float
    centre: float
    high: float
    machine: str


def transfer(run: Run, target: CanaryFile) -> Transfer:
    """The band by which times of a run change on the target; raises CanaryError without canaries."""
    here = {row.method: row.call_p50_us for row in run.rows if row.vehicle == NO_VEHICLE}
    ratios = [us / there for name, us in target.median_us.items() if (there := here.get(name))]
    if not ratios:
        raise CanaryError("this run holds none of the file's canaries; run again with this version")
    centre = prod(ratios) ** (1 / len(ratios))
    machine = str(target.machine.get("cpu") or "the target")
    return Transfer(min(ratios) / WIDENING, centre, max(ratios) * WIDENING, machine)


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
        """Number of them that would have made a call late that takes ``p50_us`` [us]."""
        return self._tally.later(limit_us, p50_us)

    @cached_property
    def _tally(self) -> Tally:
        return Tally(self.excess)


@lru_cache(maxsize=4)
def find_pauses(run: Run) -> Pauses:
    """The pauses that a run's yardsticks show."""
    excess: list[Histogram] = []
    exposure = 0.0
    for row in run.rows:
        # NAME_esc on a board allocates nothing either, but is asked this and that: its work is not fixed.
        fixed = row.described.yardstick and not row.measured.cells[0].worst
        if row.measured.singles and (fixed or row.vehicle == NO_VEHICLE):
            median = time_at_rank(row.measured.singles, total(row.measured.singles) / 2)
            excess.append([(ns - median, count) for ns, count in row.measured.singles if ns > median])
            exposure += sum(ns * count for ns, count in row.measured.singles)
    return Pauses(merge(excess), exposure)


def machine_excuse(
    singles: Tally, late: int, limit_us: float, p50_us: float, steps: int | None, pauses: Pauses
) -> str:
    """Reason why the late calls are the machine's, in words; empty where they may be the method's own.

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


def is_surely_late(late: int, calls: int) -> bool:
    """True if so many late calls of all have less than the probability CHANCE at a share of LATE_SHARE."""
    from scipy.special import betainc

    return late > 0 and bool(betainc(late, calls - late + 1, LATE_SHARE) < CHANCE)


def sizes(run: Run, loop: Loop, transfer: Transfer | None = None, demands: str = "") -> list[Size]:
    """Every method, start and level of a run, ``rank_sizes``; on all demand sets, or on one.

    With a ``transfer`` every time is multiplied by the upper end of its band. A slowest call belongs to the
    machine that made it and is not transferred.
    """
    pools = method_pools(run)
    if transfer or demands:
        groups = [[row for row in rows if demands in ("", row.demands)] for rows in sized_methods(run)]
        pools = [pool_rows(run, rows, transfer, demands) for rows in groups if rows]
    return rank_sizes([pool.size(loop) for pool in pools], loop.period_us)


def sized_methods(run: Run) -> list[list[Row]]:
    """The rows of each method, start and level on each vehicle, without yardsticks."""
    return [rows for rows in run.by_method.values() if not rows[0].described.yardstick]


@lru_cache(maxsize=4)
def method_pools(run: Run) -> "list[Pool]":
    """Pools of ``sized_methods`` on all demand sets."""
    return [pool_rows(run, rows) for rows in sized_methods(run)]


@dataclass(frozen=True)
class Pool:
    """Measured times of one method, start and level on some demand sets: its size, but for the loop.

    Attributes
    ----------
    static : all of the size that no loop changes; with a reason it is unfit for any
    singles : single calls on all the sets, [(time [ns], how often), …], sorted
    pauses : of fixed work in the same run; None where times are estimated for another machine
    """

    static: Size
    singles: Histogram
    pauses: Pauses | None

    @cached_property
    def _tally(self) -> Tally:
        return Tally(self.singles)

    def size(self, loop: Loop) -> Size:
        """The size in a loop."""
        own = self.static
        if own.reason:
            return own
        late, bound = self.late(loop.limit_us)
        fit, reason, machines, often = self.verdict(loop.limit_us)
        return replace(
            own,
            fit=fit,
            reason=reason,
            machines=machines,
            often=often,
            late=late,
            bound=bound,
            rate_hz=loop.highest_rate_hz(own.max_us) if own.max_us else None,
        )

    def late(self, limit_us: float) -> tuple[int, float | None]:
        """Number of calls later than a limit, and the bound on their share: None without calls."""
        late = self._tally.later(limit_us)
        return late, late_bound(late, self.static.calls) if self.static.calls else None

    def verdict(self, limit_us: float) -> tuple[Fit, str, bool, bool]:
        """Fit of calls to a limit, why not better, whether late calls were the machine's, or come often."""
        static, (late, bound) = self.static, self.late(limit_us)
        excuse = ""
        if self.pauses and static.p50_us is not None:
            excuse = machine_excuse(self._tally, late, limit_us, static.p50_us, static.steps, self.pauses)
        if excuse:  # an excused call counts as if it had not been late
            fit, reason = judge_times(limit_us, static.p50_us, None, None, late_bound(0, static.calls))
        else:
            fit, reason = judge_times(
                limit_us, static.p50_us, static.p999_us, static.max_us, bound, estimated=self.pauses is None
            )
        often = (
            fit == Fit.WITHOUT_TAIL
            and bool(self.pauses)
            and not excuse
            and is_surely_late(late, static.calls)
        )
        return fit, reason or excuse, bool(excuse), often


def pool_rows(run: Run, rows: Sequence[Row], transfer: Transfer | None = None, demands: str = "") -> Pool:
    """The pool of one method's rows on all demand sets, or on one of that name.

    What a method misses of all sets that were drawn is counted on the demands drawn evenly, which are the
    most, and the same for each method.
    """
    first, asked = rows[0], run.problem_by_set
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
        reason=unfit_reason(rows),
    )
    if size.reason:
        return Pool(size, [], None)
    factor = transfer.high if transfer else 1.0
    singles = [(ns * factor, count) for ns, count in merge(row.measured.singles for row in rows)]
    p50 = _times(factor, largest_of_all(row.call_p50_us for row in rows))
    tail = quantile(singles, 0.999)
    problems = [asked.get((row.vehicle, row.demands)) for row in rows]
    known = [each for each in problems if each]
    moving = any(p.moving and p.given for p in known) or (bool(known) and all(p.moving for p in known))
    exact, count = is_exact_everywhere(rows), None if demands else served_count(run, first)
    even = count.sample if count else None
    refusals = [refusal(row, each, even) for row, each in zip(rows, problems, strict=True)]
    violating = first.unlimited and any(row.limits_violated_share for row in rows)
    unanswered = violating or any(each.unanswered for each in refusals)
    # The gap without demands drawn evenly: these condemn a method, or do not, and more may say otherwise.
    else_gap = 2 if any(each.share for each in refusals) else int(unanswered)
    of_even = even_refusal(even)
    said = max((each for each in (*refusals, of_even) if each.words), default=NONE)
    missing, n, n_even = missing_share(rows, problems, count)
    # What is exact misses none of more demands either; another that missed none of so few may.
    _, low, high = share(round(missing * n), n) if n and not exact else (0.0, missing, missing)
    size = replace(
        size,
        exact=exact,
        missing=missing,
        missing_low=low,
        missing_high=high,
        n_even=n_even,
        misses=count.missed if count else b"",
        unanswered=unanswered or said.unanswered,
        other_gap=(else_gap if of_even.words else 2) if is_even_refusal_open(even) else None,
        refused=said.share,
        refusal=said.words,
        part=" and ".join(part_note(each) for each in known if each.left_out and not each.given),
        moving=moving,
        picky=refuses(first.formulation) and said.words not in MISSES,
        p50_us=p50,
        p999_us=None if tail is None or p50 is None or tail / 1000 < p50 else tail / 1000,
        max_us=None if transfer or not singles else singles[-1][0] / 1000,
        calls=total(singles),
        cpu_us=_times(factor, largest_of_all(row.call_cpu_p50_us for row in rows)),
        memory_MB=largest_of_all(row.peak_rss_MB for row in rows),
        steps=first.worst_case_steps,
    )
    return Pool(size, singles, None if transfer else find_pauses(run))


def part_note(problem: Problem) -> str:
    """Part of a sequence that was asked, in words."""
    return (
        f"of {problem.demands}'s {problem.n_demands + problem.left_out:,} demands {problem.n_demands:,} asked"
    )


def is_exact_everywhere(rows: Sequence[Row]) -> bool:
    """True if a method is exact on all of these rows that ask attainable demands, and there is one."""
    # On a set without attainable demands an exact method may have no answers to be judged by.
    asked = [row for row in rows if row.measured.attainable or row.agreed is not None]
    return all(is_exact(row) for row in asked) and any(is_exact(row) for row in rows)


def missing_share(
    rows: Sequence[Row], problems: Sequence[Problem | None], count: Served | None
) -> tuple[float, int, int]:
    """The share of demands that can be met of which more than SERVED_WITHIN is left out, a mean of sets.

    Given a ``count`` of demands drawn evenly, it stands for all sets but logs and missions. Of other sets the
    share is 0 where none is left out. What is delivered within SERVED_WITHIN counts demands just beyond the
    limits too, and these may hide one that is left out: where any is, the share is SERVED_WITHIN at least.

    Returns
    -------
    share : what is left out [-]
    n : demands that it is a share of
    n_even : the same where ``count`` alone says it, else 0
    """
    pairs = zip(rows, problems, strict=True)
    own = [row for row, problem in pairs if not (count and problem and is_random(problem))]
    known = [(row.within_1pct_share, row.measured.attainable) for row in own]
    served = [min(within / can, 1.0) for within, can in known if within is not None and can > 0]
    n = round(sum(row.measured.attainable * row.n_demands for row in own))
    least = SERVED_WITHIN if (largest_miss(own) or 0.0) > SERVED_WITHIN else 0.0
    if count and len(own) < len(rows):
        served, n = [*served, count.within_1pct / count.n_demands], n + count.n_demands
    elif not least:
        return 0.0, n, 0
    missing = max(1.0 - fmean(served), least) if served else 1.0
    return missing, n, 0 if own or not count else count.n_demands


def _times(factor: float, us: float | None) -> float | None:
    return None if us is None else factor * us
