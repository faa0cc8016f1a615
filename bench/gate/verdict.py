"""Verdict of a gate, the statistics of paired times behind it, and the report as Markdown and JSON."""

from collections.abc import Sequence
from enum import IntEnum
from math import exp, isfinite, log, sqrt
from statistics import fmean, median, stdev
from typing import Any, NamedTuple

import msgspec

from bench.gate.record import GateCell, GateRecord, GateSettings
from bench.results.quantiles import CONFIDENCE
from bench.results.text import plain, plural, table, with_code

Blocks = Sequence[tuple[int, int]]


class Ratio(NamedTuple):
    """Time of the head over that of the base.

    Attributes
    ----------
    value : the estimate of head / base [-]
    lower, upper : ends of its 95 % interval [-]
    """

    value: float
    lower: float
    upper: float


def ratio(pairs: Sequence[Blocks]) -> Ratio:
    """R = exp(mean m_p), Student's t on the P values m_p = median over blocks of ln(head / base).

    Blocks within a pair share two processes with their layouts, so they are no samples of their own.
    A single pair says nothing about the spread: its interval is (0, inf).
    """
    m = [median(log(head / base) for base, head in blocks) for blocks in pairs]
    mean = fmean(m)
    if len(m) < 2:
        return Ratio(exp(mean), 0.0, float("inf"))
    from scipy.special import stdtrit  # scipy.stats, which has the whole test, takes a second to import

    half = float(stdtrit(len(m) - 1, (1 + CONFIDENCE) / 2)) * stdev(m) / sqrt(len(m))
    assert isfinite(half)
    return Ratio(exp(mean), exp(mean - half), exp(mean + half))


def medians_us(pairs: Sequence[Blocks], calls: int) -> tuple[float, float]:
    """Median time of a call over all blocks, base and head [µs]."""
    base, head = (median(block[side] for blocks in pairs for block in blocks) for side in (0, 1))
    return base / calls / 1e3, head / calls / 1e3


CERTAIN = 1.01
"""A cell fails only where the whole interval of its ratio lies above this."""
TRIPWIRE = 1.01
"""Counts of instructions on identical trees differ by far less than 1 %, so 1 % is a change of the code."""
CONTROL_DRIFT = 0.03
"""A control cell has the same code on both sides: where its time moves by this much, the machine changed."""
BEYOND_NOISE = 2.0
"""A cell whose whole interval lies above this is slower, whatever pairs were left out for lack of time."""
ABOUT_TIME = "no answer got worse; inconclusive about time"
"""Said where times decide nothing: answers, which need no quiet machine, have passed before."""


class Outcome(IntEnum):
    """The gate's exit code."""

    PASS = 0
    REGRESSION = 1
    INCONCLUSIVE = 3


class Standing(NamedTuple):
    """Comparison of a gate cell's two sides in time.

    Attributes
    ----------
    name : ``vehicle:method:start``
    ratio : time of head over base [-]
    base_us, head_us : median time of a call [us]
    instructions : count of head over base [-], None where not counted
    threshold : the ratio above which a cell is slower [-]
    """

    name: str
    ratio: Ratio
    base_us: float
    head_us: float
    instructions: float | None
    threshold: float


class Regression(NamedTuple):
    """One reason why the gate fails.

    Attributes
    ----------
    cell : the cell's name, ``-`` where none is to blame
    what : what got worse
    """

    cell: str
    what: str


class Verdict(NamedTuple):
    """Verdict of a gate.

    Attributes
    ----------
    outcome : pass, regression or inconclusive
    summary : the outcome in one sentence
    findings : what got worse, cell by cell
    improvements : cells that got faster
    rows : all timed cells but the controls
    """

    outcome: Outcome
    summary: str
    findings: Sequence[Regression] = ()
    improvements: Sequence[Standing] = ()
    rows: Sequence[Standing] = ()


def verdict(record: GateRecord) -> Verdict:
    """Verdict, in this order: no change; missing cells; wrong answers; instructions; machine; time."""
    if record.unchanged:
        return Verdict(Outcome.PASS, f"pass at once: {record.unchanged}")
    compared = [cell for cell in record.cells if in_both(cell)]
    answering = [cell for cell in record.cells if not cell.head_lacks]  # new ones too
    gone = [cell for cell in record.cells if cell.head_lacks and not cell.base_lacks]
    lost = [Regression(cell.name, f"gone: {cell.head_lacks}") for cell in gone]
    lost += [Regression("-", record.crashed)] if record.crashed else []
    wrong = [Regression(cell.name, what) for cell in answering if (what := _wrong_answer(cell))]
    if not lost and not wrong and all(cell.is_control for cell in compared):
        return Verdict(Outcome.INCONCLUSIVE, "nothing to compare: no cell stands on both sides")
    timed = [cell for cell in compared if cell.pairs]
    rows = [row(cell, record.settings) for cell in timed if not cell.is_control]
    still = [row(cell, record.settings) for cell in timed if cell.is_control]
    drift = max((r.ratio.value for r in still), default=1.0)
    doubled = {r.name for r in rows if r.ratio.lower > BEYOND_NOISE * drift}
    confirmed = {cell.name for cell in timed if len(cell.pairs) >= 2 * record.settings.pairs} | doubled
    heavier = [Regression(cell.name, what) for cell in compared if (what := _heavier(cell))]
    slower = [Regression(r.name, _slow(r)) for r in rows if r.name in confirmed and is_slower(r)]
    moved = ", ".join(f"{r.name} by {r.ratio.value - 1:+.1%}" for r in still if is_disturbed(r))
    turned = any(cell.turned_wrong for cell in answering)
    kind = "cells are gone" if lost else "answers are wrong" if turned else "other answers"
    rules = (
        (lost or wrong, Outcome.REGRESSION, f"regression: {kind}"),
        (heavier, Outcome.REGRESSION, "regression: more instructions per call"),
        (doubled, Outcome.REGRESSION, "regression: slower"),
        # A budget that was spent comes before the controls, because over a few pairs they move by chance.
        (record.cut, Outcome.INCONCLUSIVE, f"{ABOUT_TIME}: {record.cut}"),
        (
            moved,
            Outcome.INCONCLUSIVE,
            f"{ABOUT_TIME}: cells that no commit can change moved ({moved}); try a quieter machine",
        ),
        (slower, Outcome.REGRESSION, "regression: slower"),
        (True, Outcome.PASS, f"pass: {plural(len(rows), 'cell')}, none slower than its threshold"),
    )
    outcome, summary = next((outcome, summary) for reason, outcome, summary in rules if reason)
    improvements = [r for r in rows if is_faster(r)]
    return Verdict(outcome, summary, lost + wrong + heavier + slower, improvements, rows)


def in_both(cell: GateCell) -> bool:
    """True if both sides have the cell."""
    return not cell.base_lacks and not cell.head_lacks


def row(cell: GateCell, settings: GateSettings) -> Standing:
    """A cell's ratio, medians and threshold, over all pairs measured so far."""
    base_us, head_us = medians_us(cell.pairs, cell.calls)
    return Standing(
        name=cell.name,
        ratio=ratio(cell.pairs),
        base_us=base_us,
        head_us=head_us,
        instructions=cell.instructions[-1][1] / cell.instructions[-1][0] if cell.instructions else None,
        threshold=1 + settings.threshold,
    )


def is_suspect(cell: GateCell, settings: GateSettings) -> bool:
    """True if the first stage sees a slow-down that fresh pairs must confirm."""
    r = row(cell, settings)
    return r.ratio.value > r.threshold and r.ratio.lower > 1


def is_slower(r: Standing) -> bool:
    """True if the pairs of both stages together show a slow-down beyond doubt."""
    return r.ratio.value > r.threshold and r.ratio.lower > CERTAIN


def is_faster(r: Standing) -> bool:
    """True if a cell got faster, by the mirror image of ``is_slower``; listed, it changes no verdict."""
    return r.ratio.value < 1 / r.threshold and r.ratio.upper < 1 / CERTAIN


def is_disturbed(r: Standing) -> bool:
    """True if a control cell's time shows that the two sides were not measured alike."""
    return r.ratio.value > 1 + CONTROL_DRIFT or r.ratio.value < 1 / (1 + CONTROL_DRIFT)


def trips(counts: tuple[float, float]) -> bool:
    """True if instructions per call (base, head) grew by more than 1 %."""
    base, head = counts
    return head > TRIPWIRE * base


def _wrong_answer(cell: GateCell) -> str:
    if cell.turned_wrong:
        return f"{'new, and wrong' if cell.base_lacks else 'wrong answer'}: {cell.turned_wrong}"
    return f"another answer: {cell.differ}" if cell.differ else ""


def _heavier(cell: GateCell) -> str:
    # A single count is a suspicion. A second count, from fresh processes, confirms it.
    if len(cell.instructions) < 2 or not all(map(trips, cell.instructions)):
        return ""
    base, head = cell.instructions[-1]
    return f"instructions per call {base:,.0f} → {head:,.0f} ({head / base - 1:+.1%})"


def _slow(r: Standing) -> str:
    low, high = r.ratio.lower - 1, r.ratio.upper - 1
    return f"{r.base_us:.3f} → {r.head_us:.3f} µs, {r.ratio.value - 1:+.1%} ({low:+.1%} … {high:+.1%})"


SIGNS = {0: "✅", 1: "❌", 3: "❔"}


def markdown(record: GateRecord, result: Verdict, *, folded: bool = True) -> str:
    """The verdict as a reviewer wants to read it: findings first, details folded away.

    Folding takes HTML, so a terminal gets the details as they are.
    """

    def details(title: str, text: str) -> list[str]:
        if folded:
            return [f"<details><summary>{title}</summary>", "", text, "</details>", ""]
        return [f"**{title}**", "", text]

    between = f"{plural(len(record.commits), 'commit')} between them" if record.commits else "two trees"
    lines = [
        f"## {SIGNS[result.outcome]} Gate: {result.summary}",
        "",
        f"base `{record.base}` → head `{record.head}`, {between}",
        "",
    ]
    if result.findings:
        lines.append(table(("cell", "what"), [(f"`{cell}`", what) for cell, what in result.findings]))
    suspects = {finding.cell for finding in result.findings}
    slow = [row for row in result.rows if row.name in suspects]
    for title, rows in (("Suspects", slow), ("Faster", result.improvements)):
        lines += [f"**{title}**", "", _times(rows)] if rows else []
    lines += [f"- {with_code(note)}" for note in notes(record)] + [""] if notes(record) else []
    if result.rows:
        lines += details(f"All: {plural(len(result.rows), 'cell')}", _times(result.rows))
    if record.commits:
        lines += details("Commits", "\n".join(f"- {plain(commit)}" for commit in record.commits) + "\n")
    where = f" on {record.machine['cpu']}" if "cpu" in record.machine else ""
    seconds = ", ".join(f"{stage} {s:.0f} s" for stage, s in record.seconds.items() if stage != "all")
    lines.append(f"{seconds}; {record.seconds.get('all', 0):.0f} s in all{where}." if seconds else "")
    return "\n".join(lines).rstrip() + "\n"


def notes(record: GateRecord) -> list[str]:
    """Remarks that change no verdict: the record's notes; new, mended and on both sides wrong cells."""
    remarks = list(record.notes)
    for cell in record.cells:
        if cell.base_lacks:
            remarks += [] if cell.head_lacks or cell.head_wrong else [f"new: `{cell.name}`"]
        elif cell.base_wrong and cell.head_wrong:
            what = cell.head_wrong
            if cell.base_wrong != cell.head_wrong:
                what = f"base {cell.base_wrong}; head {cell.head_wrong}"
            remarks.append(f"wrong on both sides: `{cell.name}`: {what}")
        elif cell.base_wrong:
            remarks.append(f"mended: `{cell.name}`, where base had a wrong answer: {cell.base_wrong}")
    return remarks


def as_json(record: GateRecord, result: Verdict) -> str:
    """The verdict and the record it was made from."""
    summary: dict[str, Any] = {
        "outcome": result.outcome.name.lower(),
        "exit_code": int(result.outcome),
        "summary": result.summary,
        "findings": [finding._asdict() for finding in result.findings],
        "improvements": [row.name for row in result.improvements],
        "rows": [{**row._asdict(), "ratio": row.ratio._asdict()} for row in result.rows],
    }
    data = {"verdict": summary, "record": msgspec.to_builtins(record)}
    return msgspec.json.format(msgspec.json.encode(data), indent=1).decode() + "\n"


def _times(rows: Sequence[Standing]) -> str:
    headers = ("cell", "base [µs]", "head [µs]", "head/base", "95 % interval", "instructions")
    lines = [
        (
            f"`{row.name}`",
            f"{row.base_us:.3f}",
            f"{row.head_us:.3f}",
            f"{row.ratio.value:.3f}",
            f"{row.ratio.lower:.3f} … {row.ratio.upper:.3f}",
            f"{row.instructions - 1:+.2%}" if row.instructions else "–",
        )
        for row in rows
    ]
    return table(headers, lines)
