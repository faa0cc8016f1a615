"""One cell's answers, judged: those of both sides, and those that head alone gives."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from math import inf

from bench.gate.answers import SideAnswers, answered, answered_early, cut, differ, first, wrong
from bench.gate.ask_forms import ask_forms
from bench.gate.asked import ALONE, NEARLY, RESIZED, WIDER, nearly_symmetric
from bench.gate.prober import Prober
from bench.gate.record import GateCell
from bench.judging.question import Question

AGAIN = 20
"""How many demands the first allocator of a cell is asked again, after others were built."""


def judge_cell(
    cell: GateCell, sides: tuple[Prober, Prober], asked: Sequence[Question], theirs: Sequence[Question]
) -> tuple[list[str], bool]:
    """Put into the cell what its sides answer to each question.

    Returns remarks that change no verdict, and whether the head's method says that it does not cover the
    vehicle.
    """
    remarks: list[str] = []
    refused, fewest = False, inf
    whole: tuple[SideAnswers, SideAnswers] | None = None
    hard = nearly_symmetric()
    for of_base, of_head in zip([*asked, hard], [*theirs, hard], strict=True):
        base, head = _at_once(sides, cell, (of_base, of_head))
        count = min(len(side.answers) or len(of_base.demands.taus) for side in (base, head))
        if base.lacks and of_base is not asked[0]:  # it takes no limits of each call, or no failed thruster
            remarks += _one_sided(cell, of_head, base, head)
            continue
        cell.base_lacks = base.lacks or cell.base_lacks
        cell.head_lacks = _when(of_head, head.lacks) or cell.head_lacks
        refused |= head.refused
        if base.lacks or head.lacks:
            break
        if count < len(of_base.demands.taus):
            of_base, of_head = first(of_base, count), first(of_head, count)
            base, head = cut(base, count), cut(head, count)
            fewest = min(count, fewest)
        before, now = _when(of_base, wrong(of_base, base)), _when(of_head, wrong(of_head, head))
        cell.base_wrong, cell.head_wrong = cell.base_wrong or before, cell.head_wrong or now
        cell.turned_wrong = cell.turned_wrong or ("" if before else now)
        # On such edges rounding in another order may move thrusts far.
        if asked is theirs and of_base.demands.name != NEARLY:
            cell.differ = cell.differ or _when(of_base, differ(of_base, base, head))
        whole = whole or (base, head)
    if whole:
        _ask_again(cell, sides, (asked[0], theirs[0]), whole)
        ask_forms(cell, sides, (asked[0], theirs[0]), whole)
    if fewest < inf:
        remarks.append(
            f"asked only {fewest:,} demands of some kind, since its calls take so long: `{cell.name}`"
        )
    return list(dict.fromkeys(remarks)), refused


def _one_sided(cell: GateCell, question: Question, base: SideAnswers, head: SideAnswers) -> list[str]:
    """Judge what head alone answers, by equations; returns remarks, also on what neither side answers."""
    limits = question.demands.f_min is not None
    kind = "limits of each call" if limits else f"answers with {question.demands.name}"
    if head.lacks:
        how = f"`{cell.name}` fails on both sides: {head.lacks}"
        return [] if base.refused and head.refused else [f"no {kind} were compared: {how}"]
    now = _when(question, wrong(question, head))
    cell.head_wrong, cell.turned_wrong = cell.head_wrong or now, cell.turned_wrong or now
    return [f"{kind} are new: `{cell.name}`"]


def _ask_again(
    cell: GateCell,
    sides: tuple[Prober, Prober],
    questions: tuple[Question, Question],
    whole: tuple[SideAnswers, SideAnswers],
) -> None:
    """Ask the allocators of the whole vehicle again: those built for failures since must not change them."""
    found = []
    for side, question, before in zip(sides, questions, whole, strict=True):
        few, then = first(question, AGAIN), cut(before, AGAIN)
        again = answered_early(side, cell, few, then)
        other = again.lacks or differ(few, then, again)
        found.append(f"answers otherwise once another is built for a failure: {other}" if other else "")
    base, head = found
    cell.base_wrong, cell.head_wrong = cell.base_wrong or base, cell.head_wrong or head
    cell.turned_wrong = cell.turned_wrong or ("" if base else head)


def _when(question: Question, what: str) -> str:
    """What was found, and where: given what, with which thruster off, or on the nearly symmetric vehicle."""
    other = question.demands.name in (NEARLY, RESIZED, WIDER, *ALONE) or question.demands.vehicle.whole
    return f"{question.demands.name}: {what}" if what and other else what


def _at_once(
    sides: tuple[Prober, Prober],
    cell: GateCell,
    questions: tuple[Question, Question],
) -> list[SideAnswers]:
    """Both sides' answers, asked for side by side, since each takes a core for seconds."""
    with ThreadPoolExecutor(2) as pool:
        try:
            return list(pool.map(answered, sides, (cell, cell), questions))
        except BaseException:  # Ctrl-C: nobody waits for the replies any more
            for side in sides:
                side.kill()
            raise
