"""The limits set for the generated C beside what was counted."""

from collections.abc import Sequence

from bench.record import Processor
from bench.results.emulated import EmulatedRow, by_name
from bench.results.goals import GOALS, STACK_BYTES
from bench.results.text import table


def goals(rows: Sequence[EmulatedRow], processors: Sequence[Processor]) -> str:
    """Table of the goals and the counts, for kernels that were counted; a missed goal is marked."""
    boards = [(one, scalar) for one in by_name(processors) if one.goal for scalar in one.scalars]
    by_kernel: dict[tuple[str, ...], list[EmulatedRow]] = {}
    for row in rows:
        kernel = row.emulated
        if (kernel.limits, kernel.faults) != ("fixed", "one"):
            continue
        key = (kernel.vehicle, kernel.method, kernel.target, kernel.scalar)
        by_kernel.setdefault(key, []).append(row)
    lines = []
    for vehicle, method, most in GOALS:
        cells = [
            _counted(by_kernel.get((vehicle, method, one.name, scalar), []), (one.goal or 0.0) * most)
            for one, scalar in boards
        ]
        if any(any(cell) for cell in cells):
            lines.append([vehicle, method, str(most), *(text for cell in cells for text in cell)])
    headers = ["vehicle", "method", "at most"]
    for one, scalar in boards:
        headers += [f"{one.name} {scalar}", f"stack [B], {STACK_BYTES} at most"]
    return table(headers, lines) if lines else ""


def _counted(rows: Sequence[EmulatedRow], most: float) -> tuple[str, str]:
    counted = [row for row in rows if row.worst is not None]
    if not counted:
        return "", ""
    worst = max(row.worst or 0 for row in counted)
    stack = max(row.emulated.stack_bytes or 0 for row in counted)
    return _marked(worst, most), _marked(stack, STACK_BYTES)


def _marked(value: int, most: float) -> str:
    return str(value) if value <= most else f"{value}, missed"
