"""Which method fits a control rate: its times, its late calls, and a verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import itemgetter

from bench.record import NO_VEHICLE, Problem
from bench.results.columns import Row
from bench.results.fit import LATE_SHARE, Fit, Loop
from bench.results.pauses import Pauses, pauses, whose
from bench.results.quantiles import Histogram, late_bound, merged, misses, quantile
from bench.results.ranking import exact, right
from bench.results.repeats import most
from bench.results.rows import Run
from bench.results.text import counted, percent, three
from bench.results.transfer import Transfer

CLOSE = 1.5
"""Median CPU times within this factor count as equal: noise swaps them from run to run. Among equals a method
whose worst case is known comes first."""


@dataclass(frozen=True, kw_only=True)
class Size:
    """One method, with its start and level, on one vehicle over all its demand sets, or one of them.

    Attributes
    ----------
    vehicle, method, label : what was sized; the label is method, start and level
    twin, family, solver, formulation : of the method, as the record describes it
    fit : the verdict
    reason : what prevents a better ``fit``, or why late calls do not; empty where nothing does
    exact : whether it is exact wherever an attainable demand was asked
    refused : share of the demands that a user brought that got no thrusts [-]; of several files the largest
    refusal : that, or what else it refuses, in words; empty where it answers all
    freedom : n - rank T of the vehicle, None where it is not known
    p50_us : median on the demand set that takes longest [us], None where there are too few calls
    p999_us, max_us : p99.9 and the slowest of the single calls on all sets together [us], or None; a set with
        so few calls that its median lies above such a p99.9 leaves it unknown
    late, calls : number of late single calls, and of all single calls
    bound : share of late calls that is not exceeded with 95 % confidence [-]
    machines : whether the late calls were the machine's, not the method's
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
    fit: Fit
    reason: str
    exact: bool = False
    refused: float = 0.0
    refusal: str = ""
    freedom: int | None = None
    p50_us: float | None = None
    p999_us: float | None = None
    max_us: float | None = None
    late: int = 0
    calls: int = 0
    bound: float | None = None
    machines: bool = False
    cpu_us: float | None = None
    rate_hz: float | None = None
    memory_MB: float | None = None
    steps: int | None = None


def sizes(run: Run, loop: Loop, transfer: Transfer | None = None, demands: str = "") -> list[Size]:
    """Every method, start and level of a run, the one to take first; on all demand sets, or on one.

    Methods are sorted by whether their median fits, then by whether they answer all demands that a user
    brought, then by whether they are exact, then by whether their tail fits too, then by their median CPU
    time; of what lies CLOSE, one with a known worst case is first.
    So exactness is given up only where no exact method keeps up, and not for one late call in a million.

    With a ``transfer`` every time is multiplied by the upper end of its band. A slowest call belongs to the
    machine that made it and is not transferred.
    """
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in run.rows:
        measures = row.described.yardstick or row.vehicle == NO_VEHICLE
        if not measures and demands in ("", row.demands):
            groups.setdefault((row.vehicle, row.label), []).append(row)
    held_up = pauses(run)
    asked = {(p.vehicle, p.demands): p for p in run.record.problems}
    return ordered([_size(rows, loop, transfer, held_up, asked) for rows in groups.values()])


def ordered(sizes: Sequence[Size]) -> list[Size]:
    """Sizes by vehicle, the one to take first: the order that ``sizes`` describes."""
    classes: dict[tuple[str, bool, bool, bool, Fit], list[Size]] = {}
    for size in sorted(sizes, key=lambda s: (_median(s), s.label)):
        rank = (size.vehicle, size.fit > Fit.MAY_FIT, size.refused > 0, not size.exact, size.fit)
        classes.setdefault(rank, []).append(size)
    found = []
    for _, left in sorted(classes.items()):
        while left:
            close = [size for size in left if _median(size) <= CLOSE * _median(left[0])]
            found += sorted(close, key=lambda size: size.steps is None)
            left = left[len(close) :]
    return found


def _median(size: Size) -> float:
    return size.p50_us or 0.0 if size.cpu_us is None else size.cpu_us


def best_of_each(sizes: list[Size]) -> list[Size]:
    """The first start and level of each method on each vehicle."""
    first: dict[tuple[str, str], Size] = {}
    for size in sizes:
        first.setdefault((size.vehicle, size.method), size)
    return list(first.values())


def worst(there: Mapping[str, Size]) -> Size:
    """What one method takes and promises in the worst of several places, by name: machines, or vehicles."""
    place, size = max(there.items(), key=lambda item: item[1].fit)
    known = [s.p999_us for s in there.values()]
    rates = [s.rate_hz for s in there.values() if s.rate_hz is not None]
    return replace(
        size,
        reason=f"{place}: {size.reason}" if size.reason else "",
        exact=all(s.exact for s in there.values()),
        refused=max(s.refused for s in there.values()),
        refusal=max(there.values(), key=lambda s: (s.refused, s.refusal)).refusal,
        p50_us=most(s.p50_us for s in there.values()),
        p999_us=None if None in known else most(known),
        max_us=most(s.max_us for s in there.values()),
        cpu_us=most(s.cpu_us for s in there.values()),
        late=sum(s.late for s in there.values()),
        calls=sum(s.calls for s in there.values()),
        bound=most(s.bound for s in there.values()),
        rate_hz=min(rates, default=None),
        memory_MB=most(s.memory_MB for s in there.values()),
    )


def of_all_vehicles(sizes: Sequence[Size]) -> list[str]:
    """The labels of all methods by their worst on any vehicle, the most useful first."""
    by_label: dict[str, dict[str, Size]] = {}
    for size in sizes:
        by_label.setdefault(size.label, {})[size.vehicle] = size
    return [size.label for size in ordered([replace(worst(own), vehicle="") for own in by_label.values()])]


def _size(
    rows: list[Row],
    loop: Loop,
    transfer: Transfer | None,
    held_up: Pauses,
    asked: Mapping[tuple[str, str], Problem],
) -> Size:
    first = rows[0]
    problem = asked.get((first.vehicle, first.demands))
    size = partial(
        Size,
        vehicle=first.vehicle,
        method=first.method,
        label=first.label,
        twin=first.described.twin,
        family=first.family,
        solver=first.described.solver,
        formulation=first.formulation,
        freedom=problem.nullity if problem else None,
    )
    if reason := unfit(rows):
        return size(fit=Fit.UNKNOWN, reason=reason)
    factor = transfer.high if transfer else 1.0
    singles: Histogram = merged(row.measured.singles for row in rows)
    medians = [row.call_p50_us for row in rows]
    p50 = _largest(medians, factor)
    tail = quantile(singles, 0.999)
    p999 = None if tail is None or p50 is None or tail / 1000 * factor < p50 else tail / 1000 * factor
    slowest = None if transfer or not singles else singles[-1][0] / 1000
    late, calls, bound = misses(singles, loop.limit_us * 1000 / factor) if singles else (0, 0, None)
    steps = first.worst_case_steps
    excuse = "" if transfer or p50 is None else whose(singles, late, loop.limit_us, p50, steps, held_up)
    if excuse:
        fit, reason = judge(loop, p50, None, None, late_bound(0, calls))  # as if none had been late
    else:
        fit, reason = judge(loop, p50, p999, slowest, bound, estimated=transfer is not None)
    longest = slowest or p999 or p50
    refusals = [refusal(row, asked.get((row.vehicle, row.demands))) for row in rows]
    refused, words = max((found for found in refusals if found[1]), key=itemgetter(0), default=(0.0, ""))
    return size(
        exact=exact_everywhere(rows),
        refused=refused,
        refusal=words,
        fit=fit,
        reason=reason or excuse,
        p50_us=p50,
        p999_us=p999,
        max_us=slowest,
        late=late,
        calls=calls,
        bound=bound,
        machines=bool(excuse),
        cpu_us=_largest([row.call_cpu_p50_us for row in rows], factor),
        rate_hz=loop.highest_rate_hz(longest) if longest else None,
        memory_MB=_largest([row.peak_rss_MB for row in rows], 1.0),
        steps=steps,
    )


def unfit(rows: Sequence[Row]) -> str:
    """Why a method on these rows has no time at all: not measured, or wrong; empty where it has one."""
    for row in rows:
        if row.failed:
            return f"{row.demands}: {row.failed.status}, {row.failed.reason}"
    for row in rows:
        if reason := wrong(row):
            return reason
    return ""


def refusal(row: Row, problem: Problem | None) -> tuple[float, str]:
    """The share of a user's demands that got no thrusts, and in words what got none; 0 and empty for nothing.

    Of demands that were drawn to be beyond what the vehicle can do a share would say nothing.
    """
    answered = row.answered_share
    if answered is None or answered == 1.0:
        return 0.0, ""
    if problem is None or not problem.given:
        return 0.0, "what can't be met"
    words = f"{percent(1 - answered)} of {row.demands}"
    run = max(judged.refused_longest for judged in row.measured.judged)
    if run and problem.rate_hz:
        words += f", up to {three(run / problem.rate_hz)} s at a stretch"
    elif run:
        words += f", up to {counted(run, 'demand')} in a row"
    return 1 - answered, words


def wrong(row: Row) -> str:
    """Why a row's answers rule out a verdict on its time; empty where they are right, or there are none."""
    if row.failed or right(row):
        return ""
    reason = row.wrong or "farther from the optimum than promised"
    return f"a wrong answer has no time; {row.demands}: {reason}"


def exact_everywhere(rows: Sequence[Row]) -> bool:
    """Whether a method is exact on all of these rows that ask attainable demands, and there is one."""
    # On a set without attainable demands an exact method may have no answers to be judged by.
    asked = [row for row in rows if row.measured.attainable or row.agreed is not None]
    return all(exact(row) for row in asked) and any(exact(row) for row in rows)


def judge(
    loop: Loop,
    p50_us: float | None,
    p999_us: float | None,
    max_us: float | None,
    bound: float | None,
    estimated: bool = False,
) -> tuple[Fit, str]:
    """Whether a method fits by its times, and what prevents a better verdict, empty where nothing does.

    A method ``fits`` where no call was late, of so many that at most LATE_SHARE of all calls are late with
    95 % confidence; that takes 2,995 calls. It ``fits without tail`` where the median fits, and the tail does
    not or is not known. It ``does not fit`` where the median does not, and is ``unknown`` without a median.
    """
    limit = loop.limit_us
    if p50_us is None:
        return Fit.UNKNOWN, "no call was timed"
    if p50_us > limit:
        return Fit.DOES_NOT_FIT, "median"
    if p999_us is not None and p999_us > limit:
        return Fit.WITHOUT_TAIL, "p99.9"
    if estimated:
        return Fit.WITHOUT_TAIL, "estimate"
    if max_us is not None and max_us > limit:
        return Fit.WITHOUT_TAIL, "slowest call"
    if bound is None or bound > LATE_SHARE:
        return Fit.WITHOUT_TAIL, "too few calls"
    return Fit.FITS, ""


def _largest(values: list[float | None], factor: float) -> float | None:
    known = [value for value in values if value is not None]
    return max(known) * factor if len(known) == len(values) and known else None
