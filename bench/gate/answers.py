"""The answers of both sides, judged before anything is timed: a fast wrong answer is a regression."""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from alloc import (
    Allocation,
    FloatArray,
    Label,
    NotApplicable,
    Status,
    UnknownName,
    Vehicle,
)
from alloc.plain import ANY_DISTANCE
from bench.demands import DemandSet, build_demands, labelled
from bench.demands.store import VEHICLE_ARRAYS, Case
from bench.gate.cells import CONTROL_DEMANDS, DEFAULT_CELLS, chosen, controls, names
from bench.gate.record import CONTROL, GateCell
from bench.gate.side import Died, Refused, Side, SourceTree
from bench.judging.judge import judge
from bench.judging.question import Answers, Ask, Question, Unanswered, questions

ROUNDING = 1e-9
"""Distance of two answers, relative to the largest limit, that rounding in another order may make."""
DEMANDS = {"inactive": 15, "active": 15, "infeasible": 10}
"""How many demands of each kind are asked for answers. Only attainable ones are timed: an iterative solver
spends most of its time on infeasible ones, and a slow-down of the rest of a call would not show beside it."""


class Prober:
    """A worker that is started again when a cell ends it, so that the other cells are still examined."""

    def __init__(self, tree: SourceTree) -> None:
        """Start the worker and list the tree's cells; raises Died or Refused where that fails."""
        self._tree = tree
        self._side = Side(tree)
        try:
            self.cells: list[list[str]] = self._side.ask("cells")
        except BaseException:
            self._side.close()
            raise

    def ask(self, do: str, **arguments: Any) -> Any:
        """Give an order; raises Refused, or Died after the worker was started afresh."""
        try:
            return self._side.ask(do, **arguments)
        except Died:
            self._side.close()
            self._side = Side(self._tree)
            raise

    def close(self) -> None:
        """End the process."""
        self._side.close()


class SideAnswers(NamedTuple):
    """What one side's cell promises and answers.

    Attributes
    ----------
    lacks : why the side has no such cell, empty where it has
    promises : formulation, limited and tolerance, by name
    answers : one for each demand of the question
    refused : whether the method lacks because it does not cover the vehicle
    """

    lacks: str
    promises: dict[str, Any]
    answers: Sequence[Allocation]
    refused: bool = False


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
        cell.base_lacks = "" if name in of_base else "base has no such method, vehicle or start"
        cell.head_lacks = "" if name in of_head else "head has no such method, vehicle or start"
        examined.cells.append(cell)
    for name, cells in shared.items():
        question = ask_question(_vehicle(base, name), partial(_ask, base))
        demands = question.demands
        examined.demands[name] = demands.taus[demands.labels != Label.INFEASIBLE].tolist()
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
        head_question = question if same_numbers else _on_other_numbers(question, _vehicle(head, name))
        for cell in cells:
            refused = _examine(cell, (base, head), (question, head_question))
            if not (cell.base_lacks and cell.head_lacks):
                examined.cells.append(cell)
            elif not refused:  # as walsh refuses most vehicles
                examined.notes.append(
                    f"fails on both sides, so not compared: `{cell.name}`: {cell.head_lacks}"
                )
    return examined


def _examine(cell: GateCell, sides: tuple[Prober, Prober], asked: tuple[Question, Question]) -> bool:
    """Judge a cell on both sides; whether the head's method says that it does not cover the vehicle."""
    base, head = (answered(side, cell, question) for side, question in zip(sides, asked, strict=True))
    cell.base_lacks, cell.head_lacks = base.lacks, head.lacks
    cell.base_wrong, cell.head_wrong = wrong(asked[0], base), wrong(asked[1], head)
    comparable = asked[0] is asked[1] and not (base.lacks or head.lacks)
    if comparable and not cell.base_wrong and not cell.head_wrong:
        cell.differ = differ(asked[0].demands.vehicle, base, head)
    return head.refused


def ask_question(vehicle: Vehicle, ask: Ask) -> Question:
    """Demands of each kind that the vehicle has, with the right answers to them, as ``ask`` gets them."""
    sets = []
    for kind, n in DEMANDS.items():
        try:
            sets.append(build_demands(kind, vehicle, 2004, n).taus)
        except NotApplicable:  # without redundancy no demand is active
            continue
    return _question(vehicle, np.concatenate(sets), ask)


def answered(side: Prober, cell: GateCell, question: Question) -> SideAnswers:
    """Ask one side for its answers to every demand of the question."""
    try:
        promises = side.ask("build", cell=cell.name, **names(cell))
        raw = side.ask("answers", cell=cell.name, taus=question.demands.taus.tolist())
    except (Died, Refused) as reason:
        refused = isinstance(reason, Refused) and reason.kind == NotApplicable.__name__
        return SideAnswers(str(reason), {}, (), refused)
    return SideAnswers("", promises, [Allocation(np.array(f), Status(status)) for status, f in raw])


def wrong(question: Question, side: SideAnswers) -> str:
    """What is wrong with one side's answers by the equations; empty where nothing is."""
    if side.lacks:
        return ""
    judged = judge(question, side.answers, **side.promises)
    if judged.wrong:
        return judged.wrong
    if judged.agrees is False:
        return f"{judged.distance_max_N:.3g} N from the optimum, beyond its promise of {judged.tolerance:g}"
    return ""


def differ(vehicle: Vehicle, base: SideAnswers, head: SideAnswers) -> str:
    """How the right answers of two sides differ from each other; empty where they don't."""
    for promise in ("formulation", "limited"):
        if base.promises[promise] != head.promises[promise]:
            return f"{promise} {base.promises[promise]} → {head.promises[promise]}"
    for i, (a, b) in enumerate(zip(base.answers, head.answers, strict=True)):
        if a.status != b.status:
            return f"status {Status(a.status).name} → {Status(b.status).name} for demand {i}"
    F = [np.array([answer.f for answer in side.answers]) for side in (base, head)]
    apart = float(np.nan_to_num(np.abs(F[0] - F[1])).max())
    # Either side may be as far from the optimum as the base promises, in opposite directions. A method that
    # promises no distance is held to what it answered before.
    tolerance = base.promises["tolerance"]
    allowed = 2 * (tolerance if tolerance < ANY_DISTANCE else ROUNDING) * vehicle.f_scale
    return f"thrusts differ by up to {apart:.3g} N, {allowed:.3g} N allowed" if apart > allowed else ""


def _vehicle(side: Prober, name: str) -> Vehicle:
    numbers = side.ask("vehicle", name=name)
    arrays: dict[str, Any] = {key: np.array(numbers[key]) for key in VEHICLE_ARRAYS}
    return Vehicle(name=name, dof=tuple(numbers["dof"]), **arrays)


def _ask(side: Prober, method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
    # Right answers of both sides come from the base's methods, because the base is the trusted side.
    answers: list[Answers | Unanswered] = []
    cell = f"reference:{method}"
    for vehicle, taus, _, _ in cases:
        try:
            side.ask("build", cell=cell, vehicle=vehicle.name, method=method, start="-")
            raw = side.ask("answers", cell=cell, taus=taus.tolist())
        except (Died, Refused) as reason:
            answers.append(Unanswered("failed", str(reason)))
            continue
        status, F = zip(*raw, strict=True)
        answers.append(Answers(np.array(F), np.array(status, dtype=np.int8)))
    return answers


def _nobody(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
    return [Unanswered("missing", "the head is not trusted with an optimum")] * len(cases)


def _on_other_numbers(question: Question, vehicle: Vehicle) -> Question:
    # Other numbers give the same demands other labels, and no right answer is known but T* tau.
    if vehicle.k != question.demands.vehicle.k:
        raise Refused(f"{vehicle.name}: its DOF differ between the sides; give --cells without it")
    return _question(vehicle, question.demands.taus, _nobody)


def _question(vehicle: Vehicle, taus: FloatArray, ask: Ask) -> Question:
    demands: DemandSet = labelled("gate", vehicle, taus)
    return questions([demands], ask)[0]
