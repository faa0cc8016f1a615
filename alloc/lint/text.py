"""A report as JSON or as a table, as ``thrustbench check`` prints it."""

import json
from collections.abc import Sequence
from typing import get_args

from alloc.lint.probe import Probe
from alloc.lint.report import Level, Report
from alloc.vehicle.frame import described


def to_json(report: Report, tried: Sequence[Probe] | None = None) -> str:
    """One JSON object: file, usable, facts or null, findings, failures; probe where there is one."""
    probe = {} if tried is None else {"probe": [one._asdict() for one in tried]}
    return json.dumps(
        {
            "file": str(report.path),
            "usable": report.count("error") == 0,
            "facts": None if report.facts is None else report.facts._asdict(),
            "findings": [finding._asdict() for finding in report.findings],
            "failures": [failure._asdict() for failure in report.failures],
        }
        | probe,
        indent=2,
        ensure_ascii=False,
    )


def as_table(report: Report) -> str:
    """One line of facts, one line for each finding, and the number of findings by level."""
    lines = []
    if facts := report.facts:
        steps = (
            "" if facts.worst_case_steps is None else f", exact method at most {facts.worst_case_steps} steps"
        )
        lines.append(
            f"{facts.name}: {facts.k} DOF, {facts.n} thrusters, rank {facts.rank}, "
            f"d = {facts.nullity}, condition {facts.condition:.3g}{steps}, frame {described(facts.frame)}"
        )
    for level, key, line, message in report.findings:
        place = f"line {line}, " if line else ""
        named = f"{key}: {message.removeprefix(f'{key}: ')}" if key else message
        lines.append(f"{level:7}  {place}{named}")
    counts = [(report.count(level), level) for level in get_args(Level)]
    total = ", ".join(f"{count} {level}{'' if count == 1 else 's'}" for count, level in counts)
    return "\n".join([*lines, f"{report.path}: {total}"])
