"""Both sides' answers, judged before anything is timed: a fast wrong answer is a regression."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from math import inf
from typing import Any, NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.errors import UnknownName
from alloc.vehicle.checks import ARRAYS
from bench.demands import labelled
from bench.demands.store import Case
from bench.gate.answers import (
    SideAnswers,
    answered,
    answered_early,
    calls,
    cut,
    differ,
    first,
    state,
    wrong,
)
from bench.gate.ask_forms import ask_forms
from bench.gate.asked import (
    ALONE,
    NEARLY,
    RESIZED,
    WIDER,
    demand_sets,
    nearly_symmetric,
    nobody,
    timed_demands,
)
from bench.gate.cells import CONTROL_DEMANDS, DEFAULT_CELLS, chosen, controls
from bench.gate.given import unpacked
from bench.gate.prober import Prober
from bench.gate.record import CONTROL, GateCell
from bench.gate.side import Died, Refused
from bench.judging.question import Answers, Question, Unanswered, questions

AGAIN = 20
"""How many demands the first allocator of a cell is asked again, after others were built."""


class Examined(NamedTuple):
    """What is known of both sides before anything is timed.

    Attributes
    ----------
    cells : all chosen cells, judged, and the controls
    demands : by vehicle, the attainable demands (N, k) [N, N m] that its cells are timed with
    notes : remarks that change no verdict
    """

    cells: list[GateCell]
    demands: dict[str, list[list[float]]]
    notes: list[str]


def examine(base: Prober, head: Prober, patterns: Sequence[str]) -> Examined:
    """Judge every chosen cell on both sides, by equations and against each other.

    Raises UnknownName if the patterns choose none.
    """
    of_base = {cell.name: cell for cell in chosen(base.cells, patterns)}
    of_head = {cell.name: cell for cell in chosen(head.cells, patterns)}
    for pattern in patterns:
        if pattern not in DEFAULT_CELLS and not chosen([*base.cells, *head.cells], [pattern]):
            raise UnknownName(f"no cell of either side fits {pattern}; write vehicle:method:start")
    if not of_base and not of_head:
        raise UnknownName(f"no cell of either side fits {', '.join(patterns)}; write vehicle:method:start")
    examined = Examined(controls(), {CONTROL: CONTROL_DEMANDS}, [])
    shared: dict[str, list[GateCell]] = {}
    for name, cell in (of_base | of_head).items():
        if name in of_base and name in of_head:
            shared.setdefault(cell.vehicle, []).append(cell)
            continue
        cell.base_lacks = "" if name in of_base else _why_not(base, "base", cell.method)
        cell.head_lacks = "" if name in of_head else _why_not(head, "head", cell.method)
        examined.cells.append(cell)
    for name, cells in shared.items():
        vehicle = vehicle_of(base, name)
        asked = questions(demand_sets(vehicle), partial(_ask, base))
        examined.demands[name] = timed_demands(vehicle).tolist()
        try:
            same_numbers = head.ask("vehicle", name=name) == base.ask("vehicle", name=name)
        except Refused as reason:  # base loaded the vehicle just now, so it is head's file that is broken
            for cell in cells:
                cell.head_lacks = str(reason)
            examined.cells.extend(cells)
            continue
        if not same_numbers:
            examined.notes.append(
                f"{name}: its numbers differ, so each side is judged by its own, not by the other"
            )
        theirs = asked if same_numbers else _on_other_numbers(asked, vehicle_of(head, name))
        for cell in cells:
            remarks, refused = judge_cell(cell, (base, head), asked, theirs)
            examined.notes.extend(remarks)
            if not (cell.base_lacks and cell.head_lacks):
                examined.cells.append(cell)
            elif not refused:  # a refusal is no failure: walsh refuses most vehicles
                examined.notes.append(
                    f"fails on both sides, so not compared: `{cell.name}`: {cell.head_lacks}"
                )
    return examined


def _why_not(side: Prober, name: str, method: str) -> str:
    return side.not_loaded.get(method, f"{name} has no such method, vehicle or start")


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


def vehicle_of(side: Prober, name: str) -> Vehicle:
    """The vehicle of that name as a side has it."""
    numbers = side.ask("vehicle", name=name)
    arrays: dict[str, Any] = {key: np.array(numbers[key]) for key in ARRAYS}
    levels: dict[str, Any] = {key: tuple(map(tuple, numbers[key])) for key in ("priority", "groups")}
    return Vehicle(name=name, dof=tuple(numbers["dof"]), **levels, **arrays)


def _ask(side: Prober, method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
    # Right answers of both sides come from the base's methods, because the base is the trusted side.
    answers: list[Answers | Unanswered] = []
    cell = f"reference:{method}"
    for case in cases:
        try:
            side.ask("build", cell=cell, method=method, start="-", **state(case.vehicle))
            raw = side.ask("many", cell=cell, **calls(case))
        except (Died, Refused) as reason:
            answers.append(Unanswered("failed", str(reason)))
            continue
        answers.append(Answers(unpacked(raw["F"]), np.array(raw["status"], dtype=np.int8)))
    return answers


def _on_other_numbers(asked: Sequence[Question], vehicle: Vehicle) -> list[Question]:
    # Under other numbers of the vehicle labels of demands no longer hold. T* tau alone is known to be right.
    first_asked = asked[0].demands.vehicle
    for what, before, now in (("DOF", first_asked.k, vehicle.k), ("thrusters", first_asked.n, vehicle.n)):
        if before != now:
            raise Refused(f"{vehicle.name}: its {what} differ between the sides; give --cells without it")
    sets = []
    for d in (question.demands for question in asked):
        numbers = vehicle
        for i, readiness in state(d.vehicle)["weaker"]:
            numbers = numbers.with_fault(i, readiness)
        sets.append(labelled(d.name, numbers, d.taus, d.f_min, d.f_max))
    return questions(sets, nobody)
