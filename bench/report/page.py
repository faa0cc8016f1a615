"""Pages for a reader in a hurry, report.md and README.md's table, and details.md: sections in their order."""

from collections.abc import Callable, Iterable
from pathlib import Path

from alloc import AllocError
from bench.record import RecordError
from bench.report.sections import (
    capability,
    cost,
    emulation,
    facts,
    fuse,
    headline,
    losses,
    mixer,
    unannounced,
    weak,
)
from bench.results.columns import Row
from bench.results.ranking import best_rows, loss_text, representatives, served_text, shortlist
from bench.results.rows import Run
from bench.results.text import table, three

Section = Callable[[Run, frozenset[str]], str]
FIRST: tuple[Section, ...] = (
    headline.opening,
    weak.weak,
    fuse.fuse,
    mixer.mixer,
    facts.frames,
    facts.logs,
    cost.onboard,
    headline.headline,
    cost.growth,
    headline.candidates,
)
REST: tuple[Section, ...] = (
    facts.frames,
    cost.cost,
    losses.losses,
    losses.moving,
    losses.mission,
    capability.capability,
    unannounced.unannounced,
    facts.agreement,
    capability.last_metre,
    cost.tails,
    facts.slowest,
    facts.memory,
    emulation.instructions,
    facts.machine,
    facts.method,
    facts.limits,
)
"""The sections of report.md and of details.md, in their order."""
TITLE = "# What thrust allocation costs, and what it buys\n"


def page(run: Run, drawn: frozenset[str]) -> str:
    """report.md: what to take and how sure that is, the headline, and the methods worth considering."""
    counted = bool(run.record.emulated) and not run.rows
    return "\n".join([TITLE, *([emulation.summary(run)] if counted else _texts(FIRST, run, drawn)), MORE])


def details(run: Run, drawn: frozenset[str]) -> str:
    """details.md: every method, picture and fact, without empty sections; ``drawn`` names the pictures."""
    sections = REST if run.rows or not run.record.emulated else (emulation.instructions,)
    return "\n".join(["# The details: every method, picture and fact\n", *_texts(sections, run, drawn)])


def _texts(sections: Iterable[Section], run: Run, drawn: frozenset[str]) -> Iterable[str]:
    return filter(None, (section(run, drawn) for section in sections))


MORE = """## More

`report.html` is one file for a browser: choose vehicle, rate and budget, and it says what to take.
`details.md` has every method, all pictures, what was wrong or not measured, and how it was measured.
"""


START, END = "<!-- results:start -->", "<!-- results:end -->"
VEHICLES = ("ukwial", "bluerov2-heavy")
"""The paper's vehicle, and the commonest one with eight thrusters. A run without them shows its first two."""
MOST = 10
"""Most lines of the table."""


def result_table(run: Run) -> str:
    """A line for each method worth considering: its median on each vehicle; tail and loss on the last one.

    Raises RecordError for a run without times, such as one of emulated processors.
    """
    shown = [name for name in VEHICLES if name in run.vehicles] or run.vehicles[:2]
    if not shown:
        raise RecordError("this run holds no times of any vehicle, so no result table; give one that does")
    by_vehicle = {name: best_rows(run, name, run.sets(name)[0]) for name in shown}
    medians = {name: {row.method: row for row in rows} for name, rows in by_vehicle.items()}
    rows = shortlist(by_vehicle[shown[-1]])[:MOST]
    ways = {row.label: way for way, row in representatives(by_vehicle[shown[-1]]).items()}
    lines = [
        [
            f"`{row.label}`",
            ways.get(row.label, row.family),
            *(_median(medians[name].get(row.method)) for name in shown),
            three(run.tail_us(row, 0.999)),
            loss_text(row),
            served_text(run, shown[-1], row),
        ]
        for row in rows
    ]
    headers = (
        "method",
        "what it is",
        *(f"{name} [µs]" for name in shown),
        "one call in 1000 [µs]",
        "worst demand, missing",
        "demands served",
    )
    return _caption(run, shown) + "\n" + table(headers, lines)


class MarkerError(AllocError):
    """A file has no marks for the table."""


def put(path: Path, text: str, start: str = START, end: str = END) -> None:
    """Replace what stands between the two marks of a file; raises MarkerError."""
    try:
        whole = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        raise MarkerError(f"{path}: can't be read as text; give the README to update") from None
    before, opening, rest = whole.partition(start)
    _, closing, after = rest.partition(end)
    if not opening or not closing:
        raise MarkerError(f"{path}: has no '{start}' and '{end}'; write them where the table shall stand")
    path.write_text(f"{before}{start}\n{text}{end}{after}", encoding="utf-8")


def _caption(run: Run, shown: list[str]) -> str:
    cpu = run.record.header.machine.get("cpu", "this machine")
    python = run.record.header.versions.get("python", "Python")
    return (
        f"Median time of one call from Python on {cpu} with {python}, asked"
        " for what takes the thrusters to their limits. The last three columns are"
        f" {shown[-1]}'s: what one call in a thousand exceeds, and how much of the worst of these demands is"
        " not delivered. *Served* is the share of all that the vehicle can do that is delivered within 1 %.\n"
    )


def _median(row: Row | None) -> str:
    return three(row.call_p50_us) if row else ""
