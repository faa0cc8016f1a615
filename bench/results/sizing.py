"""Which method fits a processor at a control rate: shares of the period, deadline misses, whether it fits."""

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
"""A method fits if p99.9 does: no more than one call in a thousand may be late."""


@dataclass(frozen=True, kw_only=True)
class Size:
    """One method, with its start and level, on one vehicle over all its demand sets.

    Attributes
    ----------
    reason : what stands in the way of a better ``fit``, empty where nothing does
    p50_us : median of the demand set that takes longest, None where the calls do not suffice
    p999_us, max_us : p99.9 and the slowest of the single calls on all sets together, or None
    late, calls : how many of the single calls were late, of how many
    bound : share of late calls, not exceeded with 95 % confidence
    rate_hz : the highest one that the slowest call seen allows
    memory_MB : peak of the method's process
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
    """Every method of a run, the one to take first.

    Before anything else come methods whose median fits; of those the exact ones; of those the ones
    whose tail fits too; and then the cheap ones. So exactness is given up only where no exact method
    keeps up, and not for one late call in a million, which may be the machine's.

    With a ``transfer`` every time is multiplied by the upper end of its band, and a slowest call,
    which belongs to the machine that made it, is not transferred at all.
    """
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in run.rows:
        if not row.described.yardstick:
            groups.setdefault((row.vehicle, row.label), []).append(row)
    found = [_size(rows, loop, transfer) for rows in groups.values()]
    return sorted(
        found,
        key=lambda s: (s.vehicle, s.fit > Fit.WITHOUT_TAIL, not s.exact, s.fit, s.p50_us or 0.0),
    )


def canary_max_us(run: Run) -> float | None:
    """The slowest call [us] of the run's canaries, a few microseconds of fixed work: the machine's doing."""
    singles = merged(row.singles for row in run.rows if row.vehicle == NO_VEHICLE)
    return singles[-1][0] / 1000 if singles else None


def best_of_each(found: list[Size]) -> list[Size]:
    """Of each method only the start and level that comes first."""
    seen: dict[tuple[str, str], Size] = {}
    for size in found:
        seen.setdefault((size.vehicle, size.method), size)
    return list(seen.values())


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
    known = slowest or p999 or p50
    return size(
        # Where nothing attainable was asked, an exact method may have nothing to answer.
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
        rate_hz=loop.highest_rate_hz(known) if known else None,
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
    """Whether a method fits by its times, and in a word what stands in the way of a better answer.

    fits: no call seen was late, of so many that at most LATE_SHARE of all calls are (95 %
    confidence; that is 2,995). fits without tail: the median fits, the tail does not or is not
    known. does not fit: the median does not. unknown: no median.
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
