"""Which method fits a control rate: its times, its late calls, and a verdict."""

from dataclasses import dataclass
from functools import partial

from bench.record import NO_VEHICLE
from bench.results.columns import Row
from bench.results.fit import Fit, Loop
from bench.results.quantiles import Histogram, merged, misses, quantile
from bench.results.ranking import exact, right
from bench.results.rows import Run
from bench.results.transfer import Transfer

LATE_SHARE = 0.001
"""Largest share of late calls of a method that fits: one in a thousand, as p99.9 is judged."""


@dataclass(frozen=True, kw_only=True)
class Size:
    """One method, with its start and level, on one vehicle over all its demand sets.

    Attributes
    ----------
    vehicle, method, label : what was sized; the label is method, start and level
    fit : the verdict
    reason : what prevents a better ``fit``, empty where nothing does
    exact : whether it is exact wherever an attainable demand was asked
    p50_us : median on the demand set that takes longest [us], None where there are too few calls
    p999_us, max_us : p99.9 and the slowest of the single calls on all sets together [us], or None
    late, calls : number of late single calls, and of all single calls
    bound : share of late calls that is not exceeded with 95 % confidence [-]
    rate_hz : highest rate that the slowest call seen allows [Hz]
    memory_MB : peak memory of the method's process [MB]
    """

    vehicle: str
    method: str
    label: str
    fit: Fit
    reason: str
    exact: bool = False
    p50_us: float | None = None
    p999_us: float | None = None
    max_us: float | None = None
    late: int = 0
    calls: int = 0
    bound: float | None = None
    rate_hz: float | None = None
    memory_MB: float | None = None


def sizes(run: Run, loop: Loop, transfer: Transfer | None = None) -> list[Size]:
    """Every method, start and level of a run, the one to take first.

    Methods are sorted by whether their median fits, then by whether they are exact, then by whether their
    tail fits too, then by their median. So exactness is given up only where no exact method keeps up, and not
    for one late call in a million, which may be the machine's.

    With a ``transfer`` every time is multiplied by the upper end of its band. A slowest call belongs to the
    machine that made it and is not transferred.
    """
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in run.rows:
        if not row.described.yardstick:
            groups.setdefault((row.vehicle, row.label), []).append(row)
    return sorted(
        (_size(rows, loop, transfer) for rows in groups.values()),
        key=lambda s: (s.vehicle, s.fit > Fit.WITHOUT_TAIL, not s.exact, s.fit, s.p50_us or 0.0),
    )


def canary_max_us(run: Run) -> float | None:
    """The slowest call [us] of the run's canaries: a few microseconds are its work, the rest the machine."""
    singles = merged(row.singles for row in run.rows if row.vehicle == NO_VEHICLE)
    return singles[-1][0] / 1000 if singles else None


def best_of_each(sizes: list[Size]) -> list[Size]:
    """The first start and level of each method on each vehicle."""
    first: dict[tuple[str, str], Size] = {}
    for size in sizes:
        first.setdefault((size.vehicle, size.method), size)
    return list(first.values())


def _size(rows: list[Row], loop: Loop, transfer: Transfer | None) -> Size:
    size = partial(Size, vehicle=rows[0].vehicle, method=rows[0].method, label=rows[0].label)
    for row in rows:
        if row.failed:
            reason = f"{row.demands}: {row.failed.status}, {row.failed.reason}"
            return size(fit=Fit.UNKNOWN, reason=reason)
    for row in rows:
        if not right(row):
            reason = f"{row.demands}: {row.wrong or 'farther from the optimum than promised'}"
            return size(fit=Fit.UNKNOWN, reason=f"a wrong answer has no time; {reason}")
    factor = transfer.high if transfer else 1.0
    singles: Histogram = merged(row.singles for row in rows)
    p50 = _largest([row.call_p50_us for row in rows], factor)
    tail = quantile(singles, 0.999)
    p999 = None if tail is None else tail / 1000 * factor
    slowest = None if transfer or not singles else singles[-1][0] / 1000
    late, calls, bound = misses(singles, loop.limit_us * 1000 / factor) if singles else (0, 0, None)
    fit, reason = judge(loop, p50, p999, slowest, bound, estimated=transfer is not None)
    longest = slowest or p999 or p50
    return size(
        # On a set without attainable demands an exact method may have no answers to be judged by.
        exact=all(exact(row) for row in rows if row.attainable or row.agrees != "-")
        and any(exact(row) for row in rows),
        fit=fit,
        reason=reason,
        p50_us=p50,
        p999_us=p999,
        max_us=slowest,
        late=late,
        calls=calls,
        bound=bound,
        rate_hz=loop.highest_rate_hz(longest) if longest else None,
        memory_MB=_largest([row.peak_rss_MB for row in rows], 1.0),
    )


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
