"""Both sides' answers, judged before anything is timed: a fast wrong answer is a regression."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from math import inf
from typing import Any, NamedTuple

import numpy as np

from alloc import NotApplicable, Vehicle
from alloc.allocation import FloatArray
from alloc.errors import UnknownName
from alloc.vehicle.checks import ARRAYS
from bench.demands import DemandSet, build_demands, labelled
from bench.demands.near_degenerate import edge_demands, numbered
from bench.demands.store import Case
from bench.gate.answers import SideAnswers, answered, calls, differ, first, state, wrong
from bench.gate.cells import CONTROL_DEMANDS, DEFAULT_CELLS, chosen, controls
from bench.gate.prober import Prober
from bench.gate.record import CONTROL, GateCell
from bench.gate.side import Died, Refused
from bench.gate.worker import unpacked
from bench.judging.question import Answers, Question, Unanswered, questions

TIMED = {"inactive": 15, "active": 15}
"""How many demands of each kind are timed. Infeasible ones are not: an iterative solver spends most of its
time on them, and a slow-down of the rest of a call would not show beside it."""

LOOKED_AT = {"inactive": 1000, "active": 3000, "boundary": 1000, "infeasible": 1000}
"""How many demands of each kind are asked for answers. What is wrong in one of a thousand, of active demands
alone, is among 3,000 of them with a probability of 1 - 0.999^3000 = 95 %; of all, with 99.8 %."""

EDGES = 500
"""The same, of demands on vertices, edges and faces of what the vehicle can do, shortened and lengthened."""

MOVING = {"jolts": 3000}
"""The same, of demands that come with limits of their own."""

ALONE, ONE_SIDE = ("f_min alone", "f_max alone"), 100
"""Names of the sets in which calls give limits of one side, and how many of ``MOVING`` each has."""

FAILED = {"inactive": 20, "active": 40, "infeasible": 20}
"""The same, with each thruster off in turn: what a failure breaks, it breaks in many demands."""

REPEATED = 50
"""One demand of so many comes twice in a row, as an autopilot's do: what a call remembers must not matter."""

NEARLY, HARD, HARD_DEMANDS = "nearly symmetric", 13, 200
"""Name of the vehicle whose edges every method is asked too, its number, and how many demands. It has eight
thrusters, each the mirror image of its neighbours but for the last digits of T. A method that stepped onto
the thin rows of such a T missed the wrench of a third of these demands."""

SEED = 2004


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
        vehicle = _vehicle(base, name)
        asked = questions(demand_sets(vehicle), partial(_ask, base))
        examined.demands[name] = _of_kinds(vehicle, TIMED).tolist()
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
        theirs = asked if same_numbers else _on_other_numbers(asked, _vehicle(head, name))
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
    hard = nearly_symmetric()
    for of_base, of_head in zip([*asked, hard], [*theirs, hard], strict=True):
        base, head = _at_once(sides, cell, (of_base, of_head))
        count = min(len(side.answers) or len(of_base.demands.taus) for side in (base, head))
        if base.lacks and of_base is not asked[0]:  # it takes no limits of each call, or no failed thruster
            if not head.lacks:
                limits = of_base.demands.f_min is not None
                beyond = "limits of each call" if limits else f"answers with {of_base.demands.name}"
                remarks.append(f"{beyond} are new: `{cell.name}`")
            continue
        cell.base_lacks = base.lacks or cell.base_lacks
        cell.head_lacks = _when(of_head, head.lacks) or cell.head_lacks
        refused |= head.refused
        if base.lacks or head.lacks:
            break
        if count < len(of_base.demands.taus):
            of_base, of_head = first(of_base, count), first(of_head, count)
            base, head = (side._replace(answers=side.answers[:count]) for side in (base, head))
            fewest = min(count, fewest)
        before, now = _when(of_base, wrong(of_base, base)), _when(of_head, wrong(of_head, head))
        cell.base_wrong, cell.head_wrong = cell.base_wrong or before, cell.head_wrong or now
        cell.turned_wrong = cell.turned_wrong or ("" if before else now)
        # On such edges rounding in another order may move thrusts far.
        if asked is theirs and of_base.demands.name != NEARLY:
            cell.differ = cell.differ or _when(of_base, differ(of_base, base, head))
    if fewest < inf:
        remarks.append(f"of some kind only {fewest:,} demands were looked at: `{cell.name}`")
    return remarks, refused


def _when(question: Question, what: str) -> str:
    """What was found, and where: given what, with which thruster off, or on the nearly symmetric vehicle."""
    other = question.demands.name in (NEARLY, *ALONE) or question.demands.vehicle.whole
    return f"{question.demands.name}: {what}" if what and other else what


def _at_once(
    sides: tuple[Prober, Prober], cell: GateCell, questions: tuple[Question, Question]
) -> list[SideAnswers]:
    """Both sides' answers, asked for side by side, since each takes a core for seconds."""
    with ThreadPoolExecutor(2) as pool:
        try:
            return list(pool.map(answered, sides, (cell, cell), questions))
        except BaseException:  # Ctrl-C: nobody waits for the replies any more
            for side in sides:
                side.kill()
            raise


def demand_sets(vehicle: Vehicle) -> list[DemandSet]:
    """The demands that cells of a vehicle are asked.

    All kinds mixed; then those with limits of their own, of both sides and of one; then those with each
    thruster off in turn.
    """
    edges = edge_demands(vehicle, np.random.default_rng(SEED), EDGES)
    mixed = np.random.default_rng(SEED).permutation(np.vstack([_of_kinds(vehicle, LOOKED_AT), edges]))
    again = np.arange(1, len(mixed), REPEATED)
    mixed[again] = mixed[again - 1]
    moving = [build_demands(name, vehicle, SEED, n) for name, n in MOVING.items()]
    for name, *sides in ((ALONE[0], moving[0].f_min, None), (ALONE[1], None, moving[0].f_max)):
        low, high = (None if side is None else side[:ONE_SIDE] for side in sides)
        moving.append(labelled(name, vehicle, moving[0].taus[:ONE_SIDE], low, high))
    states = {i: vehicle.with_fault(i) for i in vehicle.working.tolist() if len(vehicle.working) > 1}
    failed = [labelled(f"thruster {i} off", state, _of_kinds(state, FAILED)) for i, state in states.items()]
    return [labelled("gate", vehicle, mixed), *moving, *failed]


@cache
def nearly_symmetric() -> Question:
    """Demands on the edges of a nearly symmetric vehicle, which is no cell's; judged by equations alone."""
    vehicle, rng = numbered(HARD)
    taus = edge_demands(vehicle, rng, HARD_DEMANDS)
    return questions([labelled(NEARLY, vehicle, taus)], _nobody)[0]


def _of_kinds(vehicle: Vehicle, kinds: Mapping[str, int]) -> FloatArray:
    sets = []
    for kind, n in kinds.items():
        try:
            sets.append(build_demands(kind, vehicle, SEED, n).taus)
        except NotApplicable:  # without redundancy no demand is active
            continue
    return np.concatenate(sets)


def _vehicle(side: Prober, name: str) -> Vehicle:
    numbers = side.ask("vehicle", name=name)
    arrays: dict[str, Any] = {key: np.array(numbers[key]) for key in ARRAYS}
    return Vehicle(name=name, dof=tuple(numbers["dof"]), **arrays)


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


def _nobody(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
    return [Unanswered("missing", "nobody is trusted with an optimum")] * len(cases)


def _on_other_numbers(asked: Sequence[Question], vehicle: Vehicle) -> list[Question]:
    # Under other numbers of the vehicle labels of demands no longer hold. T* tau alone is known to be right.
    first_asked = asked[0].demands.vehicle
    for what, before, now in (("DOF", first_asked.k, vehicle.k), ("thrusters", first_asked.n, vehicle.n)):
        if before != now:
            raise Refused(f"{vehicle.name}: its {what} differ between the sides; give --cells without it")
    sets = []
    for d in (question.demands for question in asked):
        numbers = vehicle
        for i in state(d.vehicle)["off"]:
            numbers = numbers.with_fault(i)
        sets.append(labelled(d.name, numbers, d.taus, d.f_min, d.f_max))
    return questions(sets, _nobody)
