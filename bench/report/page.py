"""report.md, for a reader in a hurry, and details.md: their sections in the order of a reader's questions."""

from collections.abc import Callable, Iterable

from bench.report.sections import (
    capability,
    cost,
    emulation,
    facts,
    failures,
    flights,
    growth,
    headline,
    lost,
    onboard,
    worth,
)
from bench.results.rows import Run

Section = Callable[[Run, frozenset[str]], str]
FIRST: tuple[Section, ...] = (
    headline.opening,
    facts.frames,
    facts.logs,
    onboard.section,
    headline.headline,
    growth.section,
    worth.section,
)
REST: tuple[Section, ...] = (
    facts.frames,
    cost.cost,
    lost.section,
    flights.moving,
    flights.mission,
    capability.capability,
    failures.section,
    capability.last_metre,
    cost.tails,
    facts.slowest,
    facts.memory,
    emulation.section,
    facts.machine,
    facts.method,
    facts.limits,
)
"""The sections of report.md and of details.md, in their order."""
TITLE = "# What thrust allocation costs, and what it buys\n"


def page(run: Run, drawn: frozenset[str]) -> str:
    """report.md: what to take and how sure that is, the headline, and the methods worth considering."""
    counted = bool(run.record.emulated) and not run.rows
    return "\n".join([TITLE, *([emulation.summary(run)] if counted else _written(FIRST, run, drawn)), MORE])


def details(run: Run, drawn: frozenset[str]) -> str:
    """details.md: every method, picture and fact, without empty sections; ``drawn`` names the pictures."""
    sections = REST if run.rows or not run.record.emulated else (emulation.section,)
    return "\n".join(["# The details: every method, picture and fact\n", *_written(sections, run, drawn)])


def _written(sections: Iterable[Section], run: Run, drawn: frozenset[str]) -> Iterable[str]:
    return filter(None, (section(run, drawn) for section in sections))


MORE = """## More

`report.html` is one file for a browser: choose vehicle, rate and budget, and it says what to take.
`details.md` has every method, all pictures, what was wrong or not measured, and how it was measured.
"""
