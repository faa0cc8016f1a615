"""Both sides' answers, judged before anything is timed: a fast wrong answer is a regression."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from math import inf
from typing import Any, NamedTuple

import numpy as np

from alloc import Label, Status, Vehicle
from alloc.errors import UnknownName
from alloc.vehicle.checks import ARRAYS
from bench.demands import DemandSet, labelled
from bench.demands.store import Case
from bench.gate.answers import (
    HANGS_S,
    SideAnswers,
    apart_allowed,
    ask_first_built,
    ask_side,
    calls,
    find_difference,
    find_error,
    is_useless,
    shorten,
    state,
)
from bench.gate.questions import MIXED, NEARLY, demand_sets, nearly_symmetric, nobody, timed_demands
from bench.gate.record import (
    CONTROL,
    CONTROL_DEMANDS,
    DEFAULT_CELLS,
    GateCell,
    controls,
    matching_cells,
    refuse_pattern,
)
from bench.gate.side import Died, Prober, Refused
from bench.gate.worker import unpacked
from bench.judging.question import Answers, Question, Unanswered, questions

FEW = 0.5
"""Share of demands within the limits of a closed form below which a new method gets a remark."""
AGAIN = 20
"""Number of demands that the first allocator of a cell is asked again, after others were built."""
CALLS = 20
"""Number of demands of each form of calls."""


class Examined(NamedTuple):
    """Findings about both sides before anything is timed.

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
    of_base = {cell.name: cell for cell in matching_cells(base.cells, patterns)}
    of_head = {cell.name: cell for cell in matching_cells(head.cells, patterns)}
    there = [*base.cells, *head.cells]
    for pattern in patterns:
        if not matching_cells(there, [pattern]) and (
            pattern not in DEFAULT_CELLS or not (of_base or of_head)
        ):
            raise UnknownName(refuse_pattern(there, pattern))
    examined = Examined(controls(), {CONTROL: CONTROL_DEMANDS}, [])
    by_vehicle: dict[str, list[GateCell]] = {}
    for name, cell in (of_base | of_head).items():
        cell.base_lacks = "" if name in of_base else _why_not(base, "base", cell.method)
        cell.head_lacks = "" if name in of_head else _why_not(head, "head", cell.method)
        if cell.head_lacks:
            examined.cells.append(cell)
        else:
            by_vehicle.setdefault(cell.vehicle, []).append(cell)
    for name, cells in by_vehicle.items():
        _examine_vehicle(examined, (base, head), name, cells)
    return examined


def _examine_vehicle(
    examined: Examined, sides: tuple[Prober, Prober], name: str, cells: Sequence[GateCell]
) -> None:
    """Judge a vehicle's cells, all of which head has, and put them to what is examined."""
    base, head = sides
    known = any(name == vehicle for vehicle, *_ in base.cells)
    before = side_vehicle(base, name) if known else None
    try:
        now = side_vehicle(head, name)
    except Refused as reason:  # base loaded the vehicle just now, or never had it: head's file is broken
        for cell in cells:
            note_failure(cell, str(reason))
        examined.cells.extend(cells)
        return
    asked = questions(demand_sets(before or now), partial(_ask_reference, base))
    examined.demands[name] = timed_demands(before or now).tolist()
    theirs = asked
    if before and head.ask("vehicle", name=name) != base.ask("vehicle", name=name):
        examined.notes.append(
            f"{name}: its numbers differ, so each side is judged by its own, not by the other"
        )
        theirs = _on_other_numbers(asked, now)
    for cell in cells:
        remarks, refused = ([], False) if cell.base_lacks else judge_cell(cell, sides, asked, theirs)
        if cell.base_lacks and not cell.head_lacks:
            more, refused = judge_new(cell, head, theirs)
            remarks += more
        examined.notes.extend(remarks)
        if not (cell.base_lacks and cell.head_lacks):
            examined.cells.append(cell)
        elif not refused:  # a refusal is no failure: walsh refuses most vehicles
            examined.notes.append(f"fails on both sides, so not compared: `{cell.name}`: {cell.head_lacks}")


def _why_not(side: Prober, name: str, method: str) -> str:
    return side.not_loaded.get(method, f"{name} has no such method, vehicle or start")


def side_vehicle(side: Prober, name: str) -> Vehicle:
    """The vehicle of that name as a side has it."""
    numbers = side.ask("vehicle", name=name)
    arrays: dict[str, Any] = {key: np.array(numbers[key]) for key in ARRAYS}
    levels: dict[str, Any] = {key: tuple(map(tuple, numbers[key])) for key in ("priority", "groups")}
    return Vehicle(name=name, dof=tuple(numbers["dof"]), **levels, **arrays)


def _ask_reference(side: Prober, method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
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
    # A method that is written for so many DOF and thrusters can't answer for others.
    is_other_size = asked[0].demands.vehicle.T.shape != hard.demands.vehicle.T.shape
    for of_base, of_head in zip([*asked, hard], [*theirs, hard], strict=True):
        base, head = _ask_both(sides, cell, (of_base, of_head))
        count = min(len(side.answers) or len(of_base.demands.taus) for side in (base, head))
        if base.lacks and of_base is not asked[0]:  # it takes no limits of each call, or no failed thruster
            remarks += _judge_head_alone(cell, of_head, base, head)
            continue
        if head.lacks and of_base is hard and (head.refused or is_other_size):
            own = "no longer takes the gate's own vehicle, a nearly symmetric one"
            remarks.append(f"{own}: `{cell.name}`: {head.lacks}")
            break
        cell.base_lacks = base.lacks or cell.base_lacks
        cell.head_lacks = _prefix(of_head, head.lacks) or cell.head_lacks
        refused |= head.refused
        if base.lacks or head.lacks:
            break
        if count < len(of_base.demands.taus):
            of_base, of_head = of_base.rows(slice(count)), of_head.rows(slice(count))
            base, head = shorten(base, count), shorten(head, count)
            fewest = min(count, fewest)
        before, now = (
            _prefix(of_base, find_error(of_base, base)),
            _prefix(of_head, find_error(of_head, head)),
        )
        cell.note(before, now)
        if whole is None:  # the whole vehicle's, which are asked first
            doubted = bool(before) and is_useless(of_base, base, head)
        # On such edges rounding in another order may move thrusts far.
        if asked is theirs and of_base.demands.name != NEARLY:
            cell.differ = cell.differ or _prefix(
                of_base, find_difference(of_base, base, head, doubted=doubted)
            )
        whole = whole or (base, head)
    if whole:
        cell.note(*map(_answers_otherwise, sides, (cell, cell), (asked[0], theirs[0]), whole))
        _note_forms(cell, sides, (asked[0], theirs[0]), whole)
    return list(dict.fromkeys([*remarks, *_slow(cell, fewest)])), refused


def judge_new(cell: GateCell, head: Prober, asked: Sequence[Question]) -> tuple[list[str], bool]:
    """Put into a cell that base lacks what is wrong with head's answers, by equations alone.

    No answer was right before, so a failure is wrong too, unless the method says that it does not cover what
    is asked. Returns what ``judge_cell`` does.
    """
    whole = ask_side(head, cell, asked[0])
    if whole.refused:
        cell.head_lacks = whole.lacks
        return [f"new, and does not cover the vehicle: `{cell.name}`: {whole.lacks}"], True
    fewest = inf
    for question in [*asked, nearly_symmetric()]:
        side = whole if question is asked[0] else ask_side(head, cell, question)
        # A method may say that it takes no limits or failures, and may be made for its own vehicle alone.
        if side.refused or (side.lacks and question.demands.name == NEARLY):
            continue
        count = len(side.answers)
        if not side.lacks and count < len(question.demands.taus):
            question, fewest = question.rows(slice(count)), min(count, fewest)
        if what := _prefix(question, side.lacks or find_error(question, side)):
            note_failure(cell, what)
            break
    else:
        forms = find_form_errors(head, cell, asked[0].demands, whole.promises)
        if what := _answers_otherwise(head, cell, asked[0], whole) or first_error(forms):
            note_failure(cell, what)
    return [*_solved(cell, asked[0], whole), *_slow(cell, fewest)], False


def _solved(cell: GateCell, question: Question, side: SideAnswers) -> list[str]:
    """A remark where a new cell, right by what it promises, meets few of the demands that all can meet.

    Thrusts of a tenth lie within the limits and near enough for a rule that promises no more.
    """
    inside = np.flatnonzero(question.demands.labels[: len(side.answers)] == Label.INACTIVE)
    solved = sum(side.answers[i].status == Status.SOLVED for i in inside.tolist())
    met = f"`{cell.name}`: SOLVED for {solved:,} of {len(inside):,} demands that a closed form meets"
    return [f"new, and gives less than is asked: {met}"] if solved < FEW * len(inside) else []


def note_failure(cell: GateCell, why: str) -> None:
    """Put down why head fails: what base has is gone, and what is new is wrong."""
    if cell.base_lacks:
        cell.head_wrong = cell.turned_wrong = why
    else:
        cell.head_lacks = why


def _slow(cell: GateCell, fewest: float) -> list[str]:
    """A remark where some kind had to be asked ``fewest`` demands, fewer than others are."""
    asked = f"asked only {fewest:,} demands of some kind, since its calls take so long: `{cell.name}`"
    return [asked] if fewest < inf else []


def _judge_head_alone(cell: GateCell, question: Question, base: SideAnswers, head: SideAnswers) -> list[str]:
    """Judge what head alone answers, by equations; returns remarks, also on what neither side answers."""
    limits = question.demands.f_min is not None
    kind = "limits of each call" if limits else f"answers with {question.demands.name}"
    if head.lacks:
        how = f"`{cell.name}` fails on both sides: {head.lacks}"
        return [] if base.refused and head.refused else [f"no {kind} were compared: {how}"]
    cell.note("", _prefix(question, find_error(question, head)))
    return [f"{kind} are new: `{cell.name}`"]


def _note_forms(
    cell: GateCell,
    sides: tuple[Prober, Prober],
    asked: tuple[Question, Question],
    whole: tuple[SideAnswers, SideAnswers],
) -> None:
    """Ask both sides for other forms of calls: what base answers as it does the usual ones, head must."""
    base, head = map(
        find_form_errors, sides, (cell, cell), [q.demands for q in asked], [a.promises for a in whole]
    )
    for form, what in head.items():
        if what:
            cell.note(base.get(form, ""), f"{form}: {what}")
    cell.base_wrong = cell.base_wrong or first_error(base)


def _answers_otherwise(side: Prober, cell: GateCell, question: Question, before: SideAnswers) -> str:
    """Difference of the whole vehicle's allocator now: those built for failures must not change it."""
    few, then = question.rows(slice(AGAIN)), shorten(before, AGAIN)
    again = ask_first_built(side, cell, few, then)
    count = min(len(then.answers), len(again.answers))  # of a slow one, not the same in the same time
    other = again.lacks or find_difference(
        few.rows(slice(count)), shorten(then, count), shorten(again, count)
    )
    return f"answers otherwise once another is built for a failure: {other}" if other else ""


def _prefix(question: Question, what: str) -> str:
    """Finding with the demands that it concerns, unless of all kinds: failures, limits, a vehicle."""
    name = question.demands.name
    return f"{name}: {what}" if what and name != MIXED else what


def _ask_both(
    sides: tuple[Prober, Prober],
    cell: GateCell,
    questions: tuple[Question, Question],
) -> list[SideAnswers]:
    """Both sides' answers, asked for side by side, since each takes a core for seconds."""
    with ThreadPoolExecutor(2) as pool:
        try:
            return list(pool.map(ask_side, sides, (cell, cell), questions))
        except BaseException:  # Ctrl-C: nobody waits for the replies any more
            for side in sides:
                side.kill()
            raise


def first_error(forms: Mapping[str, str]) -> str:
    """The first form that is wrong, and how; empty where none is."""
    return next((f"{form}: {what}" for form, what in forms.items() if what), "")


def find_form_errors(
    side: Prober, cell: GateCell, demands: DemandSet, promises: Mapping[str, Any]
) -> dict[str, str]:
    """Errors of each form of calls, by name; a form that a side does not have is left out."""
    vehicle, taus = demands.vehicle, demands.taus[:: max(1, len(demands.taus) // CALLS)]
    half = (np.tile(side / 2, (len(taus), 1)) for side in (vehicle.f_min, vehicle.f_max))
    try:
        asked = calls(Case(vehicle, taus, *half))
        raw = side.ask("forms", cell=cell.name, timeout=HANGS_S, **asked)
    except Died as reason:
        return {} if reason.hangs else {"other forms of calls": str(reason)}
    except Refused as reason:
        lost = reason.kind == KeyError.__name__  # its process ended meanwhile
        return {} if lost else {"other forms of calls": str(reason)}
    allowed = apart_allowed(promises, vehicle)
    return {form: _why_wrong(reply, allowed) for form, reply in raw.items()}


def _why_wrong(reply: Mapping[str, Any], allowed: float) -> str:
    """Error of a form of calls; empty for none."""
    if "raises" in reply:
        return f"raises {reply['raises']}"
    if not reply["same"]:
        return "another status than of usual calls"
    return f"thrusts {reply['apart']:.3g} N from those of usual calls" if reply["apart"] > allowed else ""
