"""A record and its verdict as Markdown, ready to be a comment, and as JSON."""

from collections.abc import Sequence
from typing import Any

import msgspec

from bench.gate.record import GateRecord
from bench.gate.verdict import Standing, Verdict
from bench.results.text import plain, plural, table, with_code

SIGNS = {0: "✅", 1: "❌", 3: "❔"}


def markdown(record: GateRecord, verdict: Verdict, *, folded: bool = True) -> str:
    """The verdict as a reviewer wants to read it: findings first, details folded away.

    Folding takes HTML, so a terminal gets the details as they are.
    """

    def details(title: str, text: str) -> list[str]:
        if folded:
            return [f"<details><summary>{title}</summary>", "", text, "</details>", ""]
        return [f"**{title}**", "", text]

    lines = [
        f"## {SIGNS[verdict.outcome]} Gate: {verdict.summary}",
        "",
        f"base `{record.base}` → head `{record.head}`, {_commits(record)}",
        "",
    ]
    if verdict.findings:
        lines.append(table(("cell", "what"), [(f"`{cell}`", what) for cell, what in verdict.findings]))
    suspects = {finding.cell for finding in verdict.findings}
    slow = [row for row in verdict.rows if row.name in suspects]
    for title, rows in (("Suspects", slow), ("Faster", verdict.improvements)):
        lines += [f"**{title}**", "", _times(rows)] if rows else []
    lines += [f"- {with_code(note)}" for note in notes(record)] + [""] if notes(record) else []
    if verdict.rows:
        lines += details(f"All: {plural(len(verdict.rows), 'cell')}", _times(verdict.rows))
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


def as_json(record: GateRecord, verdict: Verdict) -> str:
    """The verdict and the record it was made from."""
    summary: dict[str, Any] = {
        "outcome": verdict.outcome.name.lower(),
        "exit_code": int(verdict.outcome),
        "summary": verdict.summary,
        "findings": [finding._asdict() for finding in verdict.findings],
        "improvements": [row.name for row in verdict.improvements],
        "rows": [{**row._asdict(), "ratio": row.ratio._asdict()} for row in verdict.rows],
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


def _commits(record: GateRecord) -> str:
    n = len(record.commits)
    return f"{plural(n, 'commit')} between them" if n else "two trees"
