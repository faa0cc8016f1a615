"""Report section: instructions of the generated C on emulated processors, and its goals; no times."""

from collections.abc import Sequence
from itertools import product

from bench.record import ProcessorFacts
from bench.results.emulated import (
    IN_WORDS,
    PUBLISHED,
    REFERENCE,
    EmulatedRow,
    assumed_cpi,
    emulated_rows,
    latest_processors,
    table_scalar,
)
from bench.results.quantiles import group
from bench.results.rows import Run
from bench.results.text import plain, table, three

FORMS = {"fixed": "fixed limits", "call": "limits of each call"}
"""The form of limits in the C, in words."""
SEARCH, BOUNDARY = "search", "boundary"


def microcontroller(rows: Sequence[EmulatedRow], processors: Sequence[ProcessorFacts]) -> str:
    """Tables of what each method costs at worst and how often it is wrong; empty where no solver was counted.

    One for each microcontroller, in the precisions of its FPU.

    The most that any call took on each vehicle, a search included for this project's C; flash, RAM and stack
    of the vehicle that takes most; wrong verdicts and the largest distance over all vehicles. A vehicle on
    which no solver was counted is left out, or sizes would not compare.
    """
    parts = []
    boards = [
        (one.name, each)
        for one in latest_processors(processors)
        if one.microcontroller
        for each in one.scalars
    ]
    for (target, scalar), (limits, words) in product(boards, FORMS.items()):
        own = [
            row
            for row in rows
            if _kernel_form(row) == (target, scalar, limits, "one") and row.emulated.instructions
        ]
        shared = {row.emulated.vehicle for row in own if row.emulated.solver}
        if shared:
            alike = [row for row in own if row.emulated.vehicle in shared]
            board = plain(f"{target}, {scalar}")
            parts += [f"### {board}, {words}: the most instructions of a call\n", _table(alike)]
    if not parts:
        return ""
    note = (
        "A verdict is wrong where it is not that of the same method in Python off the boundary of what can be"
        " met. A solver's C is wrong where a demand can be met and got no thrusts, or can't be met and was"
        " called met. Farthest is the largest distance from the same method in Python, for a solver the"
        " optimum, over the largest limit. `pinv` knows no limits. Flash of this project's C has the tables"
        " for every single failed thruster; a solver's C knows no failure. docs/rivals.md says more.\n"
    )
    return "\n".join(["## Which method on a microcontroller\n", note, *parts])


def _kernel_form(row: EmulatedRow) -> tuple[str, ...]:
    return row.emulated.target, row.emulated.scalar, row.emulated.limits, row.emulated.faults


def _table(rows: Sequence[EmulatedRow]) -> str:
    vehicles = list(dict.fromkeys(row.emulated.vehicle for row in rows))
    by_method = group(rows, lambda row: row.emulated.method)
    lines = []
    for method, own in sorted(by_method.items(), key=lambda item: _most_instructions(item[1])):
        worst = [
            _most_instructions([row for row in own if row.emulated.vehicle == name]) for name in vehicles
        ]
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


def _most_instructions(rows: Sequence[EmulatedRow]) -> int:
    return max((row.worst or 0 for row in rows), default=0)


GOALS = (
    ("ukwial", "nullspace@native", 180),
    ("bluerov2-heavy", "nullspace@native", 430),
    ("nautilus", "nullspace@native", 430),
    ("subjugator8", "nullspace@native", 430),
    ("box8", "nullspace@native", 1200),
    ("supply-vessel", "nullspace@native", 1400),
    ("ukwial", "pinv@native", 35),
    ("bluerov2-heavy", "pinv@native", 75),
    ("supply-vessel", "pinv@native", 35),
)
"""Vehicle, method, and the most instructions of a call; a processor may take ``goal`` times as many."""
STACK_BYTES = 200
"""Most stack that a call may write."""


def goals(rows: Sequence[EmulatedRow], processors: Sequence[ProcessorFacts]) -> str:
    """Table of the goals and the counts, for kernels that were counted; a missed goal is marked."""
    boards = [(one, scalar) for one in latest_processors(processors) if one.goal for scalar in one.scalars]
    usual = (row for row in rows if (row.emulated.limits, row.emulated.faults) == ("fixed", "one"))
    by_kernel = group(usual, lambda row: row.kernel)
    lines = []
    for vehicle, method, most in GOALS:
        cells = [
            _goal_cells(by_kernel.get((vehicle, one.name, method, scalar), []), (one.goal or 0.0) * most)
            for one, scalar in boards
        ]
        if any(any(cell) for cell in cells):
            lines.append([vehicle, method, str(most), *(text for cell in cells for text in cell)])
    headers = ["vehicle", "method", "at most"]
    for one, scalar in boards:
        headers += [f"{one.name} {scalar}", f"stack [B], {STACK_BYTES} at most"]
    return table(headers, lines) if lines else ""


def _goal_cells(rows: Sequence[EmulatedRow], most: float) -> tuple[str, str]:
    counted = [row for row in rows if row.worst is not None]
    if not counted:
        return "", ""
    worst = max(row.worst or 0 for row in counted)
    stack = max(row.emulated.stack_bytes or 0 for row in counted)
    return _mark_missed(worst, most), _mark_missed(stack, STACK_BYTES)


def _mark_missed(value: int, most: float) -> str:
    return str(value) if value <= most else f"{value}, missed"


def summary(run: Run) -> str:
    """The most costly call of each kernel, in double precision if that was counted, and what failed."""
    emulated = emulated_rows(run.record.emulated)
    scalar = table_scalar(emulated)
    shown = (r.emulated for r in emulated if r.emulated.scalar == scalar and r.emulated.target != REFERENCE)
    targets = list(dict.fromkeys(each.target for each in shown))
    lines = []
    # Rows come by scalar, then by limits; here scalars don't matter.
    by_kernel = group(emulated, lambda row: _names(row, without_scalar=True))
    for names, own in sorted(by_kernel.items()):
        worst = [_most_text(own, target, scalar) for target in targets]
        if any(worst):
            lines.append([*names, *worst])
    parts = ["## Instructions on emulated processors\n"]
    if lines:
        parts.append(
            f"The most that any call without a failed thruster took in {IN_WORDS[scalar]}, a search for it"
            " included. Where emulation.csv has `instructions_known`, so are calls whose numbers overflow or"
            " are none. These are counted exactly, and no times. `thrustbench size DIR --rate HZ"
            " --clock MHZ` makes shares of a control period of them.\n"
        )
        parts.append(table(("vehicle", "method", "limits", *targets), lines))
    parts = [*filter(None, [microcontroller(emulated, run.record.processors)]), *parts]
    failed = [row for row in emulated if row.emulated.status != "ok" or row.emulated.agrees is False]
    return "\n".join([*parts, _failures(failed)] if failed else parts)


def _most_text(own: Sequence[EmulatedRow], target: str, scalar: str) -> str:
    counts = [r.costliest for r in own if (r.emulated.target, r.emulated.scalar) == (target, scalar)]
    return str(max((count for count in counts if count is not None), default=""))


def instructions(run: Run, drawn: frozenset[str]) -> str:
    """A table for each processor: mean instructions by class of demand, the worst call, flash and memory."""
    emulated = emulated_rows(run.record.emulated)
    if not emulated:
        return ""
    parts = [
        "## Instructions on emulated processors\n",
        "Instructions of one call, counted exactly; not times. Mean over the demands of each class, then the"
        " most that any call without a failed thruster took, a search for it included. The ratio is that to"
        " the same C on x86-64. Flash and RAM are what the linked image grows by, with the tables for every"
        " single failed thruster; stack is the deepest that any call wrote. docs/counting.md says how this"
        " was counted.\n",
    ]
    counted = [row for row in emulated if row.emulated.instructions and row.emulated.target != REFERENCE]
    processors = run.record.processors
    known = assumed_cpi(processors)
    for target in dict.fromkeys(row.emulated.target for row in counted):
        own = [row for row in counted if row.emulated.target == target]
        parts += [f"### {plain(target)}\n", _target_table(own)]
        if any(row.emulated.cycles for row in own):
            parts.append(f"Cycles are {PUBLISHED}.\n")
        if target in known and not all(row.emulated.cycles for row in own):
            parts.append(f"{plain(f'Cycles an instruction: {known[target]}.')}\n")
    if beside := microcontroller(counted, processors):
        parts.append(beside)
    if reached := goals(counted, processors):
        parts += ["### What was asked for, and what was found\n", reached]
    tools = {plain(f"{name} {version}") for row in counted for name, version in row.emulated.tools.items()}
    parts.append(f"Counted with {', '.join(sorted(tools))}.\n")
    failed = [row for row in emulated if row.emulated.status != "ok" or row.emulated.agrees is False]
    return "\n".join([*parts, _failures(failed)] if failed else parts)


def _target_table(counted: Sequence[EmulatedRow]) -> str:
    classes = list(dict.fromkeys(row.emulated.demands for row in counted if row.emulated.demands != "search"))
    published = ("cycles",) if any(row.emulated.cycles for row in counted) else ()
    headers = (
        *("vehicle", "method", "scalar", "limits"),
        *classes,
        *("worst", *published, "over x86", "flash [B]", "RAM [B]", "stack [B]"),
    )
    lines = []
    for names, own in group(counted, _names).items():
        by_class = {row.emulated.demands: row for row in own}
        worst = max(by_class.values(), key=lambda row: row.worst or 0)
        means = [three(by_class[name].mean) if name in by_class else "" for name in classes]
        sizes = (worst.emulated.flash_bytes, worst.emulated.ram_static_bytes)
        stack = max(row.emulated.stack_bytes or 0 for row in by_class.values())
        ratio = three(worst.worst_over_x86)
        cycles = [_cycles(list(by_class.values()))] if published else []
        lines.append([*names, *means, str(worst.worst), *cycles, ratio, *map(str, sizes), str(stack)])
    return table(headers, lines)


def _cycles(rows: Sequence[EmulatedRow]) -> str:
    """Cycles of the costliest call of a kernel, empty where no timing is published for what it executes."""
    known = [row.emulated.cycles for row in rows if row.emulated.cycles]
    return f"{max(low for low, _ in known)} to {max(high for _, high in known)}" if known else ""


def _names(row: EmulatedRow, *, without_scalar: bool = False) -> tuple[str, ...]:
    scalar = () if without_scalar else (row.emulated.scalar,)
    return row.emulated.vehicle, row.method, *scalar, row.emulated.limits


def _failures(failed: Sequence[EmulatedRow]) -> str:
    # A kernel that fails on one processor mostly fails on all, so rows with the same reason share a line.
    def names(row: EmulatedRow) -> tuple[str, str, str, str]:
        limits = "" if row.emulated.limits == "fixed" else ", limits of each call"
        return row.emulated.vehicle, f"{row.method}{limits}", row.emulated.demands, _why(row)

    lines = []
    for (vehicle, method, demands, why), own in group(failed, names).items():
        scalars = ", ".join(sorted({row.emulated.scalar for row in own}))
        targets = ", ".join(sorted({row.emulated.target for row in own}))
        lines.append([vehicle, f"{method} {scalars}", targets, demands, why])
    return table(("vehicle", "not counted, or not as in Python", "target", "demands", "why"), lines)


def _why(row: EmulatedRow) -> str:
    if row.emulated.status != "ok":
        return f"{row.emulated.status}: {row.emulated.reason}"
    distance = f"thrusts differ by up to {three(row.emulated.distance_rel_max)} of the largest limit"
    return f"{row.emulated.other_verdicts} of {row.calls} verdicts differ, {distance}"
