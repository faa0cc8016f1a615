"""What ``thrustbench size --board`` prints: every method on one board, what it takes and what it delivers."""

from collections.abc import Collection, Sequence

from alloc.errors import UnknownName
from alloc.formulations import find_formulation
from bench.record import Board, Emulated
from bench.results.bands import Counted, counted
from bench.results.emulated import by_name, rows
from bench.results.fit import Loop
from bench.results.rows import Run
from bench.results.text import percent, table, three

ATTAINABLE = ("inactive", "active")
"""Demand sets that can be met."""
BEYOND = "infeasible"


def page(run: Run, loop: Loop, board: str, vehicles: Collection[str] = ()) -> str:
    """A table for each vehicle that was counted on a board's processor; raises UnknownName for another board.

    ``vehicles`` are the only ones to show, all if empty.
    """
    places = {
        one.name: (processor, one) for processor in by_name(run.record.processors) for one in processor.boards
    }
    if board not in places:
        known = ", ".join(sorted(places)) or "none; `thrustbench emulate` of today counts for boards too"
        raise UnknownName(f"no board '{board}' in this record; there is {known}")
    processor, facts = places[board]
    own = [
        kernel
        for kernel in counted(rows(run.record.emulated), board)
        if kernel.target == processor.name and kernel.scalar in processor.scalars
        if kernel.cycles is not None and (not vehicles or kernel.vehicle in vehicles)
    ]
    parts = [_basis(facts, processor.name, loop)]
    for vehicle in dict.fromkeys(kernel.vehicle for kernel in own):
        there = [kernel for kernel in own if kernel.vehicle == vehicle]
        parts += [f"{vehicle}:\n", _table(there, facts, loop)]
    return "\n".join([*parts, _notes()])


def _table(kernels: Sequence[Counted], board: Board, loop: Loop) -> str:
    headers = (
        *("method", "scalar", "cycles, costliest call", f"share of {loop.rate_hz:g} Hz", "flash [kB]"),
        *("attainable, delivered to 1 %", "beyond: share along the demand", "largest turn"),
    )
    by_cost = sorted(kernels, key=lambda kernel: kernel.cycles or (0, 0))
    return table(headers, [_line(kernel, board, loop) for kernel in by_cost])


def _line(kernel: Counted, board: Board, loop: Loop) -> list[str]:
    low, high = kernel.cycles or (0, 0)
    shares = " to ".join(three(each / (board.clock_MHz * 1e4) * loop.rate_hz) for each in (low, high))
    asked = [row for name in ATTAINABLE if (row := kernel.rows.get(name)) is not None]
    calls = sum(_calls(row) for row in asked)
    met = sum(_calls(row) * (row.within_1pct_share or 0.0) for row in asked) / calls if calls else None
    beyond = kernel.rows.get(BEYOND)
    along = None if beyond is None else beyond.along_mean
    turned = None if beyond is None else beyond.direction_error_max_deg
    limited = find_formulation(kernel.formulation).limited
    return [
        kernel.method.removesuffix("@native") + ("" if limited else ", cut by the thrusters"),
        kernel.scalar,
        f"{low:,} to {high:,}",
        f"{shares} %",
        f"{kernel.flash_bytes / 1000:.1f}",
        "" if met is None else percent(met),
        "refuses" if along is None else f"{along:.2f}",
        "" if turned is None else f"{turned:.0f}°",
    ]


def _calls(row: Emulated) -> int:
    return sum(calls for _, calls in row.instructions)


def _basis(board: Board, processor: str, loop: Loop) -> str:
    return (
        f"{board.name}: a {processor} at {board.clock_MHz:g} MHz, {loop.rate_hz:g} Hz. Cycles are those of"
        f" the board, its flash included ({board.basis}), and not the processor's without wait states, which"
        " `size --clock` prints.\n"
    )


def _notes() -> str:
    return (
        "At least with warm caches, at most with cold ones. The costliest call is of all that were asked or"
        " found by a search. Flash has the tables for every single failed thruster. Beyond what can be met:"
        " the mean share of the demand that is delivered along it, and the largest angle between the two.\n"
    )
