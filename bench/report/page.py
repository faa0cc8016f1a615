"""report.md, for a reader in a hurry, and details.md: their sections in the order of a reader's questions."""

from bench.report import (
    capability,
    cost,
    emulation,
    failures,
    frames,
    growth,
    headline,
    last_metre,
    limits,
    lost,
    machine,
    memory,
    method,
    mission,
    moving,
    onboard,
    opening,
    slowest,
    tails,
    worth,
)
from bench.results.rows import Run

FIRST = (opening, frames, onboard, headline, growth, worth)
REST = (
    frames,
    cost,
    lost,
    moving,
    mission,
    capability,
    failures,
    last_metre,
    tails,
    slowest,
    memory,
    emulation,
    machine,
    method,
    limits,
)
TITLE = "# What thrust allocation costs, and what it buys\n"


def page(run: Run, drawn: frozenset[str]) -> str:
    """report.md: what to take and how sure that is, the headline, and the methods worth considering."""
    if not run.rows and run.record.emulated:
        return "\n".join([TITLE, emulation.summary(run), MORE])
    parts = [part.section(run, drawn) for part in FIRST]
    return "\n".join([TITLE, *(part for part in parts if part), MORE])


def details(run: Run, drawn: frozenset[str]) -> str:
    """details.md: every method, picture and fact, without empty sections; ``drawn`` names the pictures."""
    sections = REST if run.rows or not run.record.emulated else (emulation,)
    parts = [part.section(run, drawn) for part in sections]
    return "\n".join(["# The details: every method, picture and fact\n", *(part for part in parts if part)])


MORE = """## More

`report.html` is one file for a browser: choose vehicle, rate and budget, and it says what to take.
`details.md` has every method, all pictures, what was wrong or not measured, and how it was measured.
"""
