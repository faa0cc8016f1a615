"""One cell's answers, judged: those of both sides, and those that head alone gives."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from math import inf

import numpy as np

from alloc import Label, Status
from bench.gate.answers import SideAnswers, answered, answered_early, cut, differ, first, useless, wrong
from bench.gate.ask_forms import ask_forms, one_of, wrong_forms
from bench.gate.asked import MIXED, NEARLY, nearly_symmetric
from bench.gate.prober import Prober
from bench.gate.record import GateCell
from bench.judging.question import Question

FEW = 0.5
"""Share of demands within the limits of a closed form below which a new method gets a remark."""
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
    refused, doubted, fewest = False, False, inf
    whole: tuple[SideAnswers, SideAnswers] | None = None
    hard = nearly_symmetric()
    for of_base, of_head in zip([*asked, hard], [*theirs, hard], strict=True):
        base, head = _at_once(sides, cell, (of_base, of_head))
        count = min(len(side.answers) or len(of_base.demands.taus) for side in (base, head))
        if base.lacks and of_base is not asked[0]:  # it takes no limits of each call, or no failed thruster
            remarks += _one_sided(cell, of_head, base, head)
            continue
        if head.lacks and of_base is hard and (head.refused or _of_other_size(asked[0])):
            remarks.append(_made_for_its_own(cell, head))
            break
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
        if whole is None:  # the whole vehicle's, which are asked first
            doubted = bool(before) and useless(of_base, base, head)
        # On such edges rounding in another order may move thrusts far.
        if asked is theirs and of_base.demands.name != NEARLY:
            cell.differ = cell.differ or _when(of_base, differ(of_base, base, head, doubted=doubted))
        whole = whole or (base, head)
    if whole:
        _ask_again(cell, sides, (asked[0], theirs[0]), whole)
        ask_forms(cell, sides, (asked[0], theirs[0]), whole)
    return list(dict.fromkeys([*remarks, *_slow(cell, fewest)])), refused


def judge_new(cell: GateCell, head: Prober, asked: Sequence[Question]) -> tuple[list[str], bool]:
    """Put into a cell that base lacks what is wrong with head's answers, by equations alone.

    No answer was right before, so a failure is wrong too, unless the method says that it does not cover what
    is asked. Returns what ``judge_cell`` does.
    """
    whole = answered(head, cell, asked[0])
    if whole.refused:
        cell.head_lacks = whole.lacks
        return [f"new, and does not cover the vehicle: `{cell.name}`: {whole.lacks}"], True
    fewest = inf
    for question in [*asked, nearly_symmetric()]:
        side = whole if question is asked[0] else answered(head, cell, question)
        # A method may say that it takes no limits or failures, and may be made for its own vehicle alone.
        if side.refused or (side.lacks and question.demands.name == NEARLY):
            continue
        count = len(side.answers)
        if not side.lacks and count < len(question.demands.taus):
            question, fewest = first(question, count), min(count, fewest)
        if what := _when(question, side.lacks or wrong(question, side)):
            fails(cell, what)
            break
    else:
        forms = wrong_forms(head, cell, asked[0].demands, whole.promises)
        if what := _answers_otherwise(head, cell, asked[0], whole) or one_of(forms):
            fails(cell, what)
    return [*_solved(cell, asked[0], whole), *_slow(cell, fewest)], False


def _of_other_size(question: Question) -> bool:
    """True if a cell's own vehicle has another size than the nearly symmetric one.

    A method that is written for so many DOF and thrusters can't answer there.
    """
    return question.demands.vehicle.T.shape != nearly_symmetric().demands.vehicle.T.shape


def _made_for_its_own(cell: GateCell, head: SideAnswers) -> str:
    """A remark on a method that no longer takes the nearly symmetric vehicle, which is none of the user's."""
    return f"no longer takes the gate's own vehicle, a nearly symmetric one: `{cell.name}`: {head.lacks}"


def _solved(cell: GateCell, question: Question, side: SideAnswers) -> list[str]:
    """A remark where a new cell, right by what it promises, meets few of the demands that all can meet.

    Thrusts of a tenth lie within the limits and near enough for a rule that promises no more.
    """
    inside = np.flatnonzero(question.demands.labels[: len(side.answers)] == Label.INACTIVE)
    solved = sum(side.answers[i].status == Status.SOLVED for i in inside.tolist())
    met = f"`{cell.name}`: SOLVED for {solved:,} of {len(inside):,} demands that a closed form meets"
    return [f"new, and gives less than is asked: {met}"] if solved < FEW * len(inside) else []


def fails(cell: GateCell, why: str) -> None:
    """Put down why head fails: what base has is gone, and what is new is wrong."""
    if cell.base_lacks:
        cell.head_wrong = cell.turned_wrong = why
    else:
        cell.head_lacks = why


def _slow(cell: GateCell, fewest: float) -> list[str]:
    """A remark where some kind had to be asked ``fewest`` demands, fewer than others are."""
    asked = f"asked only {fewest:,} demands of some kind, since its calls take so long: `{cell.name}`"
    return [asked] if fewest < inf else []


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
    """Ask both sides' allocators of the whole vehicle again."""
    base, head = (
        _answers_otherwise(side, cell, question, before)
        for side, question, before in zip(sides, questions, whole, strict=True)
    )
    cell.base_wrong, cell.head_wrong = cell.base_wrong or base, cell.head_wrong or head
    cell.turned_wrong = cell.turned_wrong or ("" if base else head)


def _answers_otherwise(side: Prober, cell: GateCell, question: Question, before: SideAnswers) -> str:
    """How the allocator of the whole vehicle answers now: those built for failures must not change it."""
    few, then = first(question, AGAIN), cut(before, AGAIN)
    again = answered_early(side, cell, few, then)
    count = min(len(then.answers), len(again.answers))  # of a slow one, not the same in the same time
    other = again.lacks or differ(first(few, count), cut(then, count), cut(again, count))
    return f"answers otherwise once another is built for a failure: {other}" if other else ""


def _when(question: Question, what: str) -> str:
    """Finding with the demands that it concerns, unless of all kinds: failures, limits, a vehicle."""
    name = question.demands.name
    return f"{name}: {what}" if what and name != MIXED else what


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
