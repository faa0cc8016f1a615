"""Report section: each method as C on a microcontroller, solvers' own C among them, in one table."""

from collections.abc import Sequence
from itertools import product

from bench.record import Processor
from bench.results.emulated import EmulatedRow, by_name
from bench.results.text import plain, table, three

FORMS = {"fixed": "fixed limits", "call": "limits of each call"}
"""The form of limits in the C, in words."""
SEARCH, BOUNDARY = "search", "boundary"


def microcontroller(rows: Sequence[EmulatedRow], processors: Sequence[Processor]) -> str:
    """Tables of what each method costs at worst and how often it is wrong; empty where no solver was counted.

    One for each microcontroller, in the precisions of its FPU.

    The most that any call took on each vehicle, a search included for this project's C; flash, RAM and stack
    of the vehicle that takes most; wrong verdicts and the largest distance over all vehicles. A vehicle on
    which no solver was counted is left out, or sizes would not compare.
    """
    parts = []
    boards = [(one.name, each) for one in by_name(processors) if one.microcontroller for each in one.scalars]
    for (target, scalar), (limits, said) in product(boards, FORMS.items()):
        own = [
            row for row in rows if _of(row) == (target, scalar, limits, "one") and row.emulated.instructions
        ]
        shared = {row.emulated.vehicle for row in own if row.emulated.solver}
        if shared:
            alike = [row for row in own if row.emulated.vehicle in shared]
            board = plain(f"{target}, {scalar}")
            parts += [f"### {board}, {said}: the most instructions of a call\n", _table(alike)]
    if not parts:
        return ""
    note = (
        "A verdict is wrong where it is not that of the same method in Python off the boundary of what can be"
        " met; for a solver's C, where a demand can be met and got no thrusts, or can't be met and was called"
        " met. Farthest is the largest distance from the same method in Python, for a solver the optimum,"
        " over the largest limit. `pinv` knows no limits. Flash of this project's C has the tables for every"
        " single failed thruster; a solver's C knows no failure. docs/rivals.md says more.\n"
    )
    return "\n".join(["## Which method on a microcontroller\n", note, *parts])


def _of(row: EmulatedRow) -> tuple[str, ...]:
    return row.emulated.target, row.emulated.scalar, row.emulated.limits, row.emulated.faults


def _table(rows: Sequence[EmulatedRow]) -> str:
    vehicles = list(dict.fromkeys(row.emulated.vehicle for row in rows))
    by_method: dict[str, list[EmulatedRow]] = {}
    for row in rows:
        by_method.setdefault(row.emulated.method, []).append(row)
    lines = []
    for method, own in sorted(by_method.items(), key=lambda item: _most(item[1])):
        worst = [_most([row for row in own if row.emulated.vehicle == name]) for name in vehicles]
        sizes = [max(getattr(row.emulated, name) or 0 for row in own) for name in _SIZES]
        asked = [row for row in own if row.emulated.demands not in (SEARCH, BOUNDARY)]
        wrong = sum(row.emulated.other_verdicts for row in asked)
        farthest = max(row.emulated.distance_rel_max or 0.0 for row in own)
        verdicts = f"{wrong} of {sum(row.calls for row in asked)}"
        counts = [*(str(each or "") for each in worst), *map(str, sizes)]
        lines.append([method, *counts, verdicts, three(farthest)])
    headers = ("method", *vehicles, "flash [B]", "RAM [B]", "stack [B]", "wrong verdicts", "farthest")
    return table(headers, lines)


_SIZES = ("flash_bytes", "ram_static_bytes", "stack_bytes")


def _most(rows: Sequence[EmulatedRow]) -> int:
    return max((row.worst or 0 for row in rows), default=0)
