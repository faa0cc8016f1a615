"""Output of ``thrustbench size``: the method to take, how sure that is, and every method's verdict."""

from collections.abc import Mapping, Sequence
from itertools import groupby

from bench.report.verdict import rate_of, sure, verdicts, whose_rate
from bench.results.machines import NamedRun, apart, on_all
from bench.results.rows import Run
from bench.results.size import Fit, Loop, Size, best_of_each
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
    machines: Sequence[NamedRun],
    sized: Mapping[str, Sequence[Size]],
    loop: Loop,
    transfer: Transfer | None = None,
    every: bool = False,
) -> str:
    """The verdicts, how sure they are, then for each machine and vehicle a table of every method.

    ``sized`` holds all sizes by machine, in the order in which to take them. With ``every`` each start and
    level is shown, else the first of each method.
    """
    several = len(sized) > 1
    where = " on every machine that has it" if several else ""
    chosen = list if every else best_of_each
    together = chosen(on_all(sized) if several else list(next(iter(sized.values()))))
    runs = [machine.run for machine in machines]
    whose = whose_rate(*runs) if loop.rate_hz == rate_of(*runs) else []
    parts = ["\n".join([*verdicts(together, loop, where), *whose]) + "\n"]
    parts += [f"{machine.name} was {sure(machine.run)}\n" for machine in machines]
    if len(machines) > 1:
        parts.append("\n".join(["What else differs than the machine:", *apart(machines)]) + "\n")
    if transfer:
        parts.append(
            f"ESTIMATE for {transfer.machine}: nothing was run there. By its canaries a call takes"
            f" {three(transfer.centre)} times as long as here, {three(transfer.low)} to"
            f" {three(transfer.high)}; times are multiplied by the upper end. Slowest calls are not"
            " transferred.\n"
        )
    parts.append(
        f"One call may take {three(loop.limit_us)} µs, {percent(loop.limit_share)} of the control period."
        " Columns in % are shares of the period; late are single calls beyond the time allowed, with the"
        " share that their true rate does not exceed (95 % confidence, as if calls were independent); up to"
        " is the rate at which the slowest call still keeps the budget, memory the peak of the process.\n"
    )
    if several:
        for vehicle, group in groupby(together, key=lambda size: size.vehicle):
            parts.append(f"{vehicle}{where}:\n")
            parts.append(_across(vehicle, list(group), sized, loop))
    for name, own in sized.items():
        for vehicle, group in groupby(chosen(list(own)), key=lambda size: size.vehicle):
            shown = list(group)
            unknown = [f"- {size.label}: {size.reason}" for size in shown if size.fit == Fit.UNKNOWN]
            parts += [
                f"{vehicle}{f' on {name}' if several else ''}:\n",
                table(HEADERS, [_line(size, loop) for size in shown]),
                *(["Unknown, because:\n", "\n".join(unknown) + "\n"] if unknown else []),
                *(_beside(machine.run, vehicle, loop) for machine in machines if machine.name == name),
            ]
    return "\n".join(part for part in parts if part)


def _beside(run: Run, vehicle: str, loop: Loop) -> str:
    """Time of the C from thrusts to commands after each method, where a board was asked it."""
    slowest = [
        (row.call_max_us or 0.0, row.call_p50_us, row.method)
        for row in run.rows
        if row.vehicle == vehicle and row.described.yardstick and row.measured.cells[0].worst
    ]
    if not slowest:
        return ""
    longest, median, method = max(slowest)
    return (
        f"{method}, from thrusts to the commands of the ESCs, comes on top of each: median"
        f" {_share(median, loop)} %, slowest {_share(longest, loop)} % of the period.\n"
    )


def _across(vehicle: str, together: Sequence[Size], sized: Mapping[str, Sequence[Size]], loop: Loop) -> str:
    by_machine = {
        name: {size.label: size for size in own if size.vehicle == vehicle} for name, own in sized.items()
    }
    shown = {name: own for name, own in by_machine.items() if own}
    lines = []
    for size in together:
        line = [size.label, str(size.fit), _exact(size)]
        for own in shown.values():
            there = own[size.label]
            line += [str(there.fit), _share(there.p50_us, loop)]
        lines.append(line)
    headers = [part for name in shown for part in (f"{name}: verdict", "median [%]")]
    return table(("method", "verdict", "exact", *headers), lines)


def _line(size: Size, loop: Loop) -> list[str]:
    return [
        size.label,
        str(size.fit),
        "see below" if size.fit == Fit.UNKNOWN else size.reason,
        _exact(size),
        *(_share(us, loop) for us in (size.p50_us, size.p999_us, size.max_us)),
        f"{size.late} of {size.calls}" if size.calls else "",
        three(None if size.bound is None else 100 * size.bound),
        three(size.rate_hz),
        three(size.memory_MB),
    ]


def _exact(size: Size) -> str:
    return "" if size.fit == Fit.UNKNOWN else "yes" if size.exact else "no"


def _share(us: float | None, loop: Loop) -> str:
    return three(None if us is None else 100 * us / loop.period_us)
