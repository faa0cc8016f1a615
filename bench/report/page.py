"""report.md, for a reader in a hurry, and details.md: their sections in the order of a reader's questions."""

from collections.abc import Iterable

from alloc.files import modules
from bench.report.sections.emulation import summary
from bench.results.rows import Run

SECTIONS = "bench.report.sections"
FIRST = ("opening", "frames", "logs", "onboard", "headline", "growth", "worth")
REST = (
    *("frames", "cost", "lost", "moving", "mission", "capability", "failures", "last-metre", "tails"),
    *("slowest", "memory", "emulation", "machine", "method", "limits"),
)
"""Names of the sections of report.md and of details.md, in their order."""
TITLE = "# What thrust allocation costs, and what it buys\n"


def page(run: Run, drawn: frozenset[str]) -> str:
    """report.md: what to take and how sure that is, the headline, and the methods worth considering."""
    if not run.rows and run.record.emulated:
        return "\n".join([TITLE, summary(run), MORE])
    return "\n".join([TITLE, *_written(FIRST, run, drawn), MORE])


def details(run: Run, drawn: frozenset[str]) -> str:
    """details.md: every method, picture and fact, without empty sections; ``drawn`` names the pictures."""
    sections = REST if run.rows or not run.record.emulated else ("emulation",)
    title = "# The details: every method, picture and fact\n"
    return "\n".join([title, *_written(sections, run, drawn)])


def _written(sections: Iterable[str], run: Run, drawn: frozenset[str]) -> Iterable[str]:
    texts = (modules.module(SECTIONS, name).section(run, drawn) for name in sections)
    return filter(None, texts)


MORE = """## More

`report.html` is one file for a browser: choose vehicle, rate and budget, and it says what to take.
`details.md` has every method, all pictures, what was wrong or not measured, and how it was measured.
"""
