"""Output of ``thrustbench size``: the method to take, how sure that is, and every method's verdict.

Of emulated processors it is bands of shares of the period, and of one board cost and delivered share.
"""

from collections.abc import Collection, Mapping, Sequence
from itertools import groupby

from alloc.errors import UnknownName
from alloc.formulations import find_formulation
from bench.record import BoardFacts, Emulated, ProcessorFacts
from bench.report.verdict import log_rate_hz, rate_note, trust_note, verdicts
from bench.results.emulated import (
    PUBLISHED,
    Band,
    Cpi,
    KernelCost,
    assumed_cpi,
    bands,
    emulated_rows,
    find_kernels,
    latest_processors,
    refusal_reason,
)
from bench.results.machines import NamedRun, list_differences, sizes_on_all
from bench.results.rows import Run
from bench.results.size import Fit, Loop, Size, best_of_each
from bench.results.sizing import Transfer
from bench.results.text import percent, table, three

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
    together = chosen(sizes_on_all(sized, loop) if several else list(next(iter(sized.values()))))
    runs = [machine.run for machine in machines]
    whose = rate_note(*runs) if loop.rate_hz == log_rate_hz(*runs) else []
    parts = ["\n".join([*verdicts(together, loop, where), *whose]) + "\n"]
    parts += [f"{machine.name} was {trust_note(machine.run)}\n" for machine in machines]
    if len(machines) > 1:
        parts.append("\n".join(["Other differences between the runs:", *list_differences(machines)]) + "\n")
    if transfer:
        parts.append(
            f"ESTIMATE for {transfer.machine}: nothing was run there. By its canaries a call takes"
            f" {three(transfer.centre)} times as long as here, {three(transfer.low)} to"
            f" {three(transfer.high)}; times are multiplied by the upper end. Slowest calls are not"
            " transferred.\n"
        )
    parts.append(
        f"One call may take {three(loop.limit_us)} µs, {percent(loop.limit_share)} of the control period."
        " Columns in % are shares of the period. Late are single calls beyond the time allowed, with the"
        " share that their true rate does not exceed (95 % confidence, as if calls were independent). Up to"
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


def counts_page(
    run: Run, loop: Loop, clock_MHz: float | None, given: Cpi | None = None, vehicles: Collection[str] = ()
) -> str:
    """Bands for a record's emulated processors and the assumptions behind them, or what is missing for them.

    ``given`` replaces the cycles an instruction that the record assumes; ``vehicles`` are the only ones to
    show, all if empty.
    """
    if not run.record.emulated:
        return (
            "This record holds no instructions of emulated processors; `thrustbench emulate` counts them.\n"
        )
    if clock_MHz is None:
        return "This record holds instructions of emulated processors; give --clock MHZ to size with them.\n"
    known = assumed_cpi(run.record.processors)
    counted = [
        row for row in emulated_rows(run.record.emulated) if not vehicles or row.emulated.vehicle in vehicles
    ]
    if reason := refusal_reason([row.emulated for row in counted]):
        return f"Nothing was counted on emulated processors: {reason}.\n"
    shown = bands(find_kernels(counted), clock_MHz * 1e6, loop, known, given)
    bounded = any(band.kernel.at_most is not None for band in shown)
    asked = any(band.kernel.one_failed is not None for band in shown)
    off = "*One off* is the same count with any one thruster off. " * asked
    bound = "*At most* is the longest path through the binary: no call takes more. " * bounded
    parts = [
        f"Emulated processors at {clock_MHz:g} MHz, {loop.rate_hz:g} Hz. Instructions are of the costliest"
        " call that is known without a failed thruster: asked, found by a search, or with numbers that"
        f" overflow or are none. {off}{bound}The share of the control period without a failed thruster is a"
        " band, for instructions are not cycles.\n",
        table(
            (
                "vehicle",
                "target",
                "method",
                "scalar",
                "verdict",
                "exact",
                "share [%]",
                "instructions",
                "one off",
                "at most",
                "cycles",
                "answers",
            ),
            [_band(band) for band in shown],
        ),
        f"Cycles are {PUBLISHED}. Where there are none, or others are given, cycles an instruction are:\n",
    ]
    named = dict.fromkeys(band.kernel.target for band in shown)
    bases = [f"- {target}: {given or known[target]}." for target in named]
    return "\n".join([*parts, *bases, ""])


def _band(band: Band) -> list[str]:
    kernel = band.kernel
    shares = f"{three(100 * band.low)} to {three(100 * band.high)}"
    answers = "right" if kernel.agrees else "not all right"
    answers += f"; not counted: {', '.join(kernel.missed)}" if kernel.missed else ""
    optimum = "yes" if kernel.optimal else "no"
    names = [kernel.vehicle, kernel.target, kernel.method + kernel.form, kernel.scalar]
    counts = [
        "" if each is None else str(each) for each in (kernel.instructions, kernel.one_failed, kernel.at_most)
    ]
    cycles = "" if kernel.cycles is None else f"{kernel.cycles[0]} to {kernel.cycles[1]}"
    return [*names, str(band.fit), optimum, shares, *counts, cycles, answers]


ATTAINABLE_SETS = ("inactive", "active")
"""Demand sets that can be met."""
BEYOND = "infeasible"
COUNT = "`thrustbench emulate --out DIR` counts them for the boards that `thrustbench list` names"


def board_page(run: Run, loop: Loop, board: str, vehicles: Collection[str] = ()) -> str:
    """A table of all that was counted on a board's processor; raises UnknownName for another board.

    ``vehicles`` are the only ones to show, in this order; all if empty.
    """
    known = known_boards(run)
    if not known:
        raise UnknownName(f"this record has cycles of no board; {COUNT}")
    if board not in known:
        raise UnknownName(f"no board '{board}' in this record; there is {', '.join(sorted(known))}")
    processor, facts = known[board]
    kernels = [
        kernel
        for kernel in find_kernels(emulated_rows(run.record.emulated), board)
        if (kernel.target, kernel.cycles is None) == (processor.name, False)
        if kernel.scalar in processor.scalars and (not vehicles or kernel.vehicle in vehicles)
    ]
    if not kernels:
        own = [row for row in run.record.emulated if not vehicles or row.vehicle in vehicles]
        who = ", ".join(vehicles) or "this record"
        raise UnknownName(f"{who} has no cycles of {board}; {refusal_reason(own) or COUNT}")
    order = list(vehicles) or sorted({kernel.vehicle for kernel in kernels})
    kernels.sort(key=lambda kernel: (order.index(kernel.vehicle), kernel.cycles))
    return (
        f"{board}, a {processor.name} at {facts.clock_MHz:g} MHz, {'/'.join(processor.scalars)}. Cycles are"
        f" those of the board: {facts.basis}. At least with warm caches, at most with cold ones. Without"
        f" waits they are the processor's.\n\n{_kernels(kernels, facts, loop)}\n"
        "Cycles are of the costliest call that is known without a failed thruster. Over least: its"
        " instructions over those that no exact method can leave out. Flash has the tables for every failed"
        " thruster, but with --faults none. Delivered: of attainable demands, to 1 %. Beyond: what of other"
        " demands is delivered along them, in the mean, and the largest angle between the two.\n"
    )


def known_boards(run: Run) -> dict[str, tuple[ProcessorFacts, BoardFacts]]:
    """The boards that a record has cycles for, by name, each with its processor."""
    processors = latest_processors(run.record.processors)
    return {board.name: (processor, board) for processor in processors for board in processor.boards}


def _kernels(kernels: Sequence[KernelCost], board: BoardFacts, loop: Loop) -> str:
    headers = (
        "vehicle",
        "method",
        "cycles",
        "without waits",
        f"of {loop.rate_hz:g} Hz [%]",
        "over least",
        "flash [kB]",
    )
    return table(
        (*headers, "delivered", "beyond", "turned by"), [_kernel(kernel, board, loop) for kernel in kernels]
    )


def _kernel(kernel: KernelCost, board: BoardFacts, loop: Loop) -> list[str]:
    low, high = kernel.cycles or (0, 0)
    shares = [three(100 * each * loop.rate_hz / (1e6 * board.clock_MHz)) for each in (low, high)]
    asked = [row for name in ATTAINABLE_SETS if (row := kernel.rows.get(name)) is not None]
    calls = sum(_calls(row) for row in asked)
    met = sum(_calls(row) * (row.within_1pct_share or 0.0) for row in asked) / calls if calls else None
    beyond = kernel.rows.get(BEYOND)
    along = "" if beyond is None else "refused" if beyond.along_mean is None else f"{beyond.along_mean:.2f}"
    turned = None if beyond is None else beyond.direction_error_max_deg
    least = min((row.least for row in kernel.rows.values() if row.least), default=None)
    limited = find_formulation(kernel.formulation).limited
    return [
        kernel.vehicle,
        kernel.method.removesuffix("@native") + kernel.form + ("" if limited else ", cut"),
        f"{low:,}–{high:,}",
        _without(kernel),
        "–".join(shares),
        "" if least is None else three(kernel.instructions / least),
        f"{kernel.flash_bytes / 1000:.1f}",
        percent(met),
        along,
        "" if turned is None else f"{turned:.0f}°",
    ]


def _without(kernel: KernelCost) -> str:
    spans = [row.cycles for row in kernel.rows.values() if row.cycles]
    return f"{max(low for low, _ in spans):,}–{max(high for _, high in spans):,}" if spans else ""


def _calls(row: Emulated) -> int:
    return sum(calls for _, calls in row.instructions)
