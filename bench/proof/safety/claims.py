"""The claims about memory, status and limits."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from alloc.program import Program
from bench.chips.toolchain import ToolError
from bench.proof import tools
from bench.proof.altered import of_all_branches
from bench.proof.not_read import NotRead
from bench.proof.parsed import kept, of_one_branch, read
from bench.proof.proof import Claim
from bench.proof.safety import eva, limits
from bench.proof.safety.harness import harness
from bench.proof.subject import Subject
from bench.proof.symbolic import programs

OWN = "the comparison that answers (bench/proof/safety/limits.py)"
WRITTEN = ("status", "written_f", "written_share", "untouched_f", "untouched_share")
OFF = "off"
WITHIN = ("number_f", "low", "high", OFF)
SHARED = ("number_share", "share_share")
HARNESS = {*WRITTEN, *WITHIN, *SHARED}
"""Labels of the harness's assertions; what EVA decides beside them is about run-time errors."""

NO_ERROR = (
    "No run-time error: no access outside of an array, no overflow of an integer, no division by an integer"
    " zero, no read of what was never written; for every fault index and all bits of tau and limits."
)
STATUS = (
    "The status is one that the header names; f and share are written whole, or, where it is none of an"
    " answer, not touched."
)
LIMITS = (
    "Where f is written, every thrust is a number within the limits, and that of a thruster that is off is"
    " zero."
)
STATELESS = "An answer depends on its call's arguments alone: no data that can change outlive a call."
SHARES = "Every share is a number from 0 to 1."


def claims(of: Subject, folder: Path) -> list[Claim]:
    """Claims shown of the kernel, with any bits in its arguments; raises NotInstalled without Frama-C."""
    tools.need("frama-c")
    analysis = eva.analyse(harness(of), folder, *_functions(of))
    made = [
        eva.claim(NO_ERROR, analysis, *analysis.alarms(*HARNESS)),
        eva.claim(STATUS, analysis, *WRITTEN),
    ]
    if not of.limited:
        made.append(
            Claim(claim=LIMITS, verdict="does not apply", by="", words=["this method knows no limits"])
        )
    elif of.limits == "fixed":
        made.append(_fixed(of, analysis))
    else:
        made.append(_by_operations(of, OWN, partial(limits.within, n=of.vehicle.n)))
    if of.levels:
        made.append(eva.claim(SHARES, analysis, *SHARED))
    return of_all_branches([*made, _stateless(of)], of)


def _functions(of: Subject) -> tuple[set[str], set[str]]:
    """Names of the functions that return a status, and of those whose loops data end."""
    try:
        unit = of_one_branch(of)  # the analyser reads the same
    except (NotRead, ToolError):
        return set(), set()  # EVA says what is wrong with it
    return {of.name, *unit.answering}, unit.looping


def _stateless(of: Subject) -> Claim:
    return stateless(STATELESS, lambda: kept(read(of).text))


def stateless(claim: str, found: Callable[[], set[str]]) -> Claim:
    """The claim that no variable of some C, as those ``found``, is kept from one call to the next."""
    try:
        words = [f"{name} outlives a call, and can change" for name in sorted(found())]
    except (NotRead, ToolError) as reason:
        words = [str(reason)]
    return Claim(claim=claim, verdict="not shown" if words else "shown", by="the C, read", words=words)


def _fixed(of: Subject, analysis: eva.Analysis) -> Claim:
    """Intervals lose the zero of x - x: where EVA shows all but that, the operations may."""
    beside = eva.claim(LIMITS, analysis, *(label for label in WITHIN if label != OFF))
    if beside.verdict == "not shown" or not analysis.failed(OFF):
        return eva.claim(LIMITS, analysis, *WITHIN)
    return _by_operations(of, f"{eva.NAME}; that of a thruster that is off: {OWN}", limits.resting)


def _by_operations(of: Subject, by: str, unshown: Callable[[Program, int], list[str]]) -> Claim:
    """The claim on limits from the operations of each fault, of which ``unshown`` says what is missing."""
    try:
        words = [text for fault, program in programs(of).items() for text in unshown(program, fault)]
    except (NotRead, ToolError) as reason:
        words = [str(reason)]
    return Claim(claim=LIMITS, verdict="not shown" if words else "shown", by=by, words=words)
