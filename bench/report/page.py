"""report.md: the sections in the order of a reader's questions."""

from collections.abc import Callable

from bench.report import cost, failures
from bench.rows import Run

SECTIONS: tuple[Callable[[Run], str], ...] = (cost.section, failures.section)


def page(run: Run) -> str:
    """The whole report as Markdown; a section with nothing to say is left out."""
    parts = ["# What thrust allocation costs, and what it buys\n", *(section(run) for section in SECTIONS)]
    return "\n".join(part for part in parts if part)
