"""report.md: the sections in the order of a reader's questions."""

from bench.report import (
    capability,
    cost,
    emulation,
    failures,
    growth,
    headline,
    limits,
    lost,
    machine,
    memory,
    method,
    mission,
    moving,
    tails,
)
from bench.results.rows import Run

SECTIONS = (
    headline,
    cost,
    growth,
    lost,
    moving,
    mission,
    capability,
    failures,
    tails,
    memory,
    emulation,
    machine,
    method,
    limits,
)


def page(run: Run, drawn: frozenset[str]) -> str:
    """The whole report as Markdown, without empty sections; ``drawn`` are the names of the pictures."""
    sections = SECTIONS if run.rows or not run.record.emulated else (emulation,)
    parts = [part.section(run, drawn) for part in sections]
    title = "# What thrust allocation costs, and what it buys\n"
    return "\n".join([title, *(part for part in parts if part)])
