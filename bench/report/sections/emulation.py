"""Report section: instructions of the generated C on emulated processors; no times."""

from collections.abc import Sequence
from itertools import groupby

from bench.report.goals import goals
from bench.report.microcontroller import microcontroller
from bench.results.cycles import PUBLISHED, assumed
from bench.results.emulated import IN_WORDS, REFERENCE, EmulatedRow, rows, shown_scalar
from bench.results.rows import Run
from bench.results.text import plain, table, three


def summary(run: Run) -> str:
    """The most costly call of each kernel, in double precision if that was counted, and what failed."""
    emulated = rows(run.record.emulated)
    scalar = shown_scalar(emulated)
    shown = (r.emulated for r in emulated if r.emulated.scalar == scalar and r.emulated.target != REFERENCE)
    targets = list(dict.fromkeys(each.target for each in shown))
    lines = []
    # Rows come by scalar, then by limits; here scalars don't matter.
    by_kernel = sorted(emulated, key=lambda r: _names(r, without_scalar=True))
    for names, group in groupby(by_kernel, key=lambda r: _names(r, without_scalar=True)):
        own = list(group)
        worst = [_most(own, target, scalar) for target in targets]
        if any(worst):
            lines.append([*names, *worst])
    parts = ["## Instructions on emulated processors\n"]
    if lines:
        parts.append(
            f"The most that any call without a failed thruster took in {IN_WORDS[scalar]}, a search for it"
            " included, and calls whose numbers overflow or are none where emulation.csv has"
            " `instructions_known`; counted exactly, and no times. `thrustbench size DIR --rate HZ"
            " --clock MHZ` makes shares of a control period of them.\n"
        )
        parts.append(table(("vehicle", "method", "limits", *targets), lines))
    parts = [*filter(None, [microcontroller(emulated, run.record.processors)]), *parts]
    failed = [row for row in emulated if row.emulated.status != "ok" or row.emulated.agrees is False]
    return "\n".join([*parts, _failures(failed)] if failed else parts)


def _most(own: Sequence[EmulatedRow], target: str, scalar: str) -> str:
    counts = [r.known for r in own if (r.emulated.target, r.emulated.scalar) == (target, scalar)]
    return str(max((count for count in counts if count is not None), default=""))


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each processor: mean instructions by class of demand, the worst call, flash and memory."""
    emulated = rows(run.record.emulated)
    if not emulated:
        return ""
    parts = [
        "## Instructions on emulated processors\n",
        "Instructions of one call, counted exactly; not times. Mean over the demands of each class, then the"
        " most that any call without a failed thruster took, a search for it included, and its ratio to the"
        " same C on x86-64. Flash and RAM are what the linked image grows by, with the tables for every"
        " single failed thruster; stack is the deepest that any call wrote. docs/counting.md says how this"
        " was counted.\n",
    ]
    counted = [row for row in emulated if row.emulated.instructions and row.emulated.target != REFERENCE]
    processors = run.record.processors
    known = assumed(processors)
    for target in dict.fromkeys(row.emulated.target for row in counted):
        own = [row for row in counted if row.emulated.target == target]
        parts += [f"### {plain(target)}\n", _target(own)]
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


def _target(counted: Sequence[EmulatedRow]) -> str:
    classes = list(dict.fromkeys(row.emulated.demands for row in counted if row.emulated.demands != "search"))
    published = ("cycles",) if any(row.emulated.cycles for row in counted) else ()
    headers = (
        *("vehicle", "method", "scalar", "limits"),
        *classes,
        *("worst", *published, "over x86", "flash [B]", "RAM [B]", "stack [B]"),
    )
    lines = []
    for names, group in groupby(counted, key=lambda row: _names(row)):
        by_class = {row.emulated.demands: row for row in group}
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
    alike: dict[tuple[str, ...], list[EmulatedRow]] = {}
    for row in failed:
        limits = "" if row.emulated.limits == "fixed" else ", limits of each call"
        key = (row.emulated.vehicle, f"{row.method}{limits}", row.emulated.demands, _why(row))
        alike.setdefault(key, []).append(row)
    lines = []
    for (vehicle, method, demands, why), group in alike.items():
        scalars = ", ".join(sorted({row.emulated.scalar for row in group}))
        targets = ", ".join(sorted({row.emulated.target for row in group}))
        lines.append([vehicle, f"{method} {scalars}", targets, demands, why])
    return table(("vehicle", "not counted, or not as in Python", "target", "demands", "why"), lines)


def _why(row: EmulatedRow) -> str:
    if row.emulated.status != "ok":
        return f"{row.emulated.status}: {row.emulated.reason}"
    distance = f"thrusts differ by up to {three(row.emulated.distance_rel_max)} of the largest limit"
    return f"{row.emulated.other_verdicts} of {row.calls} verdicts differ, {distance}"
