"""The table of ``thrustbench size``, and the sentence in front of it."""

from itertools import groupby

from bench.results.fit import Fit, Loop
from bench.results.sizing import Size
from bench.results.text import percent, table, three
from bench.results.transfer import Transfer

HEADERS = (
    "method",
    "verdict",
    "why",
    "exact",
    "median [%]",
    "p99.9 [%]",
    "slowest [%]",
    "late",
    "late ≤ [%]",
    "up to [Hz]",
    "memory [MB]",
)


def page(
    sizes: list[Size], loop: Loop, transfer: Transfer | None = None, canary_us: float | None = None
) -> str:
    """For each vehicle what to take, every method's shares of the control period, and why some have none."""
    parts = [
        f"At {loop.rate_hz:g} Hz one call may take {three(loop.limit_us)} µs,"
        f" {percent(loop.limit_share)} of the control period. Columns in % are shares of the"
        " period; late are single calls beyond the time allowed, with the share that their true rate does not"
        " exceed (95 % confidence, as if calls were independent).\n"
    ]
    if canary_us is not None:
        parts.append(
            f"The slowest call of the canaries, a few microseconds of fixed work in the same run, took"
            f" {three(canary_us)} µs: what is late by as much may be the machine's doing, not the method's.\n"
        )
    if transfer:
        parts.append(
            f"ESTIMATE for {transfer.machine}: nothing was run there. By its canaries a call takes"
            f" {three(transfer.centre)} times as long as here, {three(transfer.low)} to"
            f" {three(transfer.high)}; times are multiplied by the upper end. Slowest calls are not"
            " transferred.\n"
        )
    for vehicle, group in groupby(sizes, key=lambda size: size.vehicle):
        own = list(group)
        unknown = [f"- {size.label}: {size.reason}" for size in own if size.fit == Fit.UNKNOWN]
        parts += [
            f"{vehicle}: {_advice(own[0], loop)}\n",
            table(HEADERS, [_line(size, loop) for size in own]),
            *(["Unknown, because:\n", "\n".join(unknown) + "\n"] if unknown else []),
        ]
    return "\n".join(parts)


def _advice(first: Size, loop: Loop) -> str:
    if first.fit > Fit.WITHOUT_TAIL:
        return f"nothing here serves {loop.rate_hz:g} Hz"
    share = percent(_of(first.p999_us or first.p50_us, loop))
    what = "p99.9" if first.p999_us else "median"
    return f"take {first.label} ({first.fit}; {what} is {share} of the period)"


def _line(size: Size, loop: Loop) -> list[str]:
    shares = [_of(us, loop) for us in (size.p50_us, size.p999_us, size.max_us)]
    return [
        size.label,
        str(size.fit),
        "see below" if size.fit == Fit.UNKNOWN else size.reason,
        "yes" if size.exact else "no",
        *(_per_cent(share) for share in shares),
        f"{size.late} of {size.calls}" if size.calls else "",
        _per_cent(size.bound),
        three(size.rate_hz),
        three(size.memory_MB),
    ]


def _per_cent(share: float | None) -> str:
    return three(None if share is None else 100 * share)


def _of(us: float | None, loop: Loop) -> float | None:
    return None if us is None else us / loop.period_us
