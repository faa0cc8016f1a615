"""Output of ``thrustbench size --board``: cost and delivered share of every method on one board."""

from collections.abc import Collection, Sequence

from alloc.errors import UnknownName
from alloc.formulations import find_formulation
from bench.record import BoardFacts, Emulated, Processor
from bench.results.bands import Counted, counted
from bench.results.emulated import by_name, rows, why_none
from bench.results.rows import Run
from bench.results.size import Loop
from bench.results.text import percent, table, three

ATTAINABLE = ("inactive", "active")
"""Demand sets that can be met."""
BEYOND = "infeasible"
COUNT = "`thrustbench emulate --out DIR` counts them for the boards that `thrustbench list` names"


def page(run: Run, loop: Loop, board: str, vehicles: Collection[str] = ()) -> str:
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
        for kernel in counted(rows(run.record.emulated), board)
        if (kernel.target, kernel.cycles is None) == (processor.name, False)
        if kernel.scalar in processor.scalars and (not vehicles or kernel.vehicle in vehicles)
    ]
    if not kernels:
        own = [row for row in run.record.emulated if not vehicles or row.vehicle in vehicles]
        who = ", ".join(vehicles) or "this record"
        raise UnknownName(f"{who} has no cycles of {board}; {why_none(own) or COUNT}")
    order = list(vehicles) or sorted({kernel.vehicle for kernel in kernels})
    kernels.sort(key=lambda kernel: (order.index(kernel.vehicle), kernel.cycles))
    return (
        f"{board}, a {processor.name} at {facts.clock_MHz:g} MHz, {'/'.join(processor.scalars)}. Cycles are"
        f" those of the board: {facts.basis}. At least with warm caches, at most with cold ones. Without"
        f" waits they are the processor's.\n\n{_table(kernels, facts, loop)}\n"
        "Cycles are of the costliest call that is known without a failed thruster. Over least: its"
        " instructions over those that no exact method can leave out. Flash has the tables for every failed"
        " thruster, but with --faults none. Delivered: of attainable demands, to 1 %. Beyond: what of other"
        " demands is delivered along them, in the mean, and the largest angle between the two.\n"
    )


def known_boards(run: Run) -> dict[str, tuple[Processor, BoardFacts]]:
    """The boards that a record has cycles for, by name, each with its processor."""
    processors = by_name(run.record.processors)
    return {board.name: (processor, board) for processor in processors for board in processor.boards}


def _table(kernels: Sequence[Counted], board: BoardFacts, loop: Loop) -> str:
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
        (*headers, "delivered", "beyond", "turned by"), [_line(kernel, board, loop) for kernel in kernels]
    )


def _line(kernel: Counted, board: BoardFacts, loop: Loop) -> list[str]:
    low, high = kernel.cycles or (0, 0)
    shares = [three(100 * each * loop.rate_hz / (1e6 * board.clock_MHz)) for each in (low, high)]
    asked = [row for name in ATTAINABLE if (row := kernel.rows.get(name)) is not None]
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


def _without(kernel: Counted) -> str:
    spans = [row.cycles for row in kernel.rows.values() if row.cycles]
    return f"{max(low for low, _ in spans):,}–{max(high for _, high in spans):,}" if spans else ""


def _calls(row: Emulated) -> int:
    return sum(calls for _, calls in row.instructions)
