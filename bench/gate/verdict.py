"""Records to verdict: a pure function, so that it can be tested on frozen ones."""

from enum import IntEnum
from typing import NamedTuple

from bench.gate.record import GateCell, GateRecord, GateSettings
from bench.gate.statistics import Ratio, medians_us, ratio

CERTAIN = 1.01
"""A failing cell's whole interval lies above this."""
TRIPWIRE = 1.01
"""Instructions: identical trees count alike to far below 1 %, so 1 % is a change of the code."""
CONTROL = 0.03
"""A control cell whose code is the same on both sides and that moves by this much: the machine moved."""


class Outcome(IntEnum):
    """What the gate says, as its exit code."""

    PASS = 0
    REGRESSION = 1
    INCONCLUSIVE = 3


class Standing(NamedTuple):
    """One timed cell: how it stands. ``instructions`` is head / base, None where not counted."""

    name: str
    ratio: Ratio
    base_us: float
    head_us: float
    instructions: float | None
    threshold: float


class Regression(NamedTuple):
    """Why the gate fails: which cell, and what about it."""

    cell: str
    what: str


class Verdict(NamedTuple):
    """The outcome, in one sentence and in detail."""

    outcome: Outcome
    summary: str
    findings: list[Regression]
    improvements: list[Standing]
    rows: list[Standing]


def verdict(record: GateRecord) -> Verdict:
    """In this order: nothing to do; missing cells; wrong answers; instructions; machine; time."""
    if record.unchanged:
        return _said(Outcome.PASS, f"pass at once: {record.unchanged}")
    lost = [Regression(cell.name, f"gone: {cell.head_lacks}") for cell in record.cells if _is_lost(cell)]
    if record.crashed:
        lost.append(Regression("-", record.crashed))
    compared = [cell for cell in record.cells if in_both(cell)]
    if not lost and not any(not cell.is_control for cell in compared):
        return _said(Outcome.REGRESSION, "nothing to compare: no cell stands on both sides")
    wrong = [Regression(cell.name, said) for cell in compared if (said := _wrong_answer(cell))]
    timed = [cell for cell in compared if cell.pairs]
    rows = [row(cell, record.settings) for cell in timed if not cell.is_control]
    confirmed = {cell.name for cell in timed if len(cell.pairs) >= 2 * record.settings.pairs}
    heavier = [Regression(cell.name, said) for cell in compared if (said := _heavier(cell))]
    slower = [Regression(r.name, _slow(r)) for r in rows if r.name in confirmed and is_slower(r)]
    improvements = [r for r in rows if is_faster(r)]

    findings = lost + wrong + heavier + slower
    moved = [r for cell in timed if cell.is_control and has_moved(r := row(cell, record.settings))]
    if lost or wrong:
        kind = "cells are gone" if lost else "answers are wrong"
        return Verdict(Outcome.REGRESSION, f"regression: {kind}", findings, improvements, rows)
    if heavier:
        summary = "regression: more instructions per call"
        return Verdict(Outcome.REGRESSION, summary, findings, improvements, rows)
    if record.cut:  # before the controls: over the few pairs there were they move by chance
        return Verdict(Outcome.INCONCLUSIVE, f"inconclusive: {record.cut}", findings, improvements, rows)
    if moved:
        names = ", ".join(f"{r.name} by {r.ratio.value - 1:+.1%}" for r in moved)
        summary = f"inconclusive: cells that no commit can change moved ({names}); try a quieter machine"
        return Verdict(Outcome.INCONCLUSIVE, summary, findings, improvements, rows)
    if slower:
        return Verdict(Outcome.REGRESSION, "regression: slower", findings, improvements, rows)
    summary = f"pass: {len(rows)} cells, none slower than its threshold"
    return Verdict(Outcome.PASS, summary, findings, improvements, rows)


def in_both(cell: GateCell) -> bool:
    """Whether there is something to compare."""
    return not cell.base_lacks and not cell.head_lacks


def row(cell: GateCell, settings: GateSettings) -> Standing:
    """A cell's ratio, medians and threshold, over all pairs measured so far."""
    base_us, head_us = medians_us(cell.pairs, cell.calls)
    counted = cell.instructions[-1][1] / cell.instructions[-1][0] if cell.instructions else None
    return Standing(cell.name, ratio(cell.pairs), base_us, head_us, counted, 1 + settings.threshold)


def is_suspect(cell: GateCell, settings: GateSettings) -> bool:
    """Whether the first stage sees a slow-down that fresh pairs must confirm."""
    r = row(cell, settings)
    return r.ratio.value > r.threshold and r.ratio.lower > 1


def is_slower(r: Standing) -> bool:
    """Whether the pairs of both stages together say so beyond doubt."""
    return r.ratio.value > r.threshold and r.ratio.lower > CERTAIN


def is_faster(r: Standing) -> bool:
    """The mirror image of ``is_slower``: listed, not gated."""
    return r.ratio.value < 1 / r.threshold and r.ratio.upper < 1 / CERTAIN


def has_moved(r: Standing) -> bool:
    """Whether a control cell says that the two sides were not measured alike."""
    return r.ratio.value > 1 + CONTROL or r.ratio.value < 1 / (1 + CONTROL)


def trips(counted: tuple[float, float]) -> bool:
    """Whether instructions per call (base, head) grew by more than 1 %."""
    base, head = counted
    return head > TRIPWIRE * base


def _is_lost(cell: GateCell) -> bool:
    return bool(cell.head_lacks) and not cell.base_lacks


def _wrong_answer(cell: GateCell) -> str:
    if cell.head_wrong and not cell.base_wrong:
        return f"wrong answer: {cell.head_wrong}"
    return f"another answer: {cell.differ}" if cell.differ else ""


def _heavier(cell: GateCell) -> str:
    # One count alone is a suspicion; the second one is made afresh, from processes of its own.
    if len(cell.instructions) < 2 or not all(trips(counted) for counted in cell.instructions):
        return ""
    base, head = cell.instructions[-1]
    return f"instructions per call {base:,.0f} → {head:,.0f} ({head / base - 1:+.1%})"


def _slow(r: Standing) -> str:
    low, high = r.ratio.lower - 1, r.ratio.upper - 1
    return f"{r.base_us:.3f} → {r.head_us:.3f} µs, {r.ratio.value - 1:+.1%} ({low:+.1%} … {high:+.1%})"


def _said(outcome: Outcome, summary: str) -> Verdict:
    return Verdict(outcome, summary, [], [], [])
