"""Both sides' answers, judged before anything is timed: a fast wrong answer is a regression."""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.errors import UnknownName
from alloc.vehicle.model import ARRAYS
from bench.demands import labelled
from bench.demands.store import Case
from bench.gate.answers import calls, state
from bench.gate.asked import demand_sets, nobody, timed_demands
from bench.gate.cells import CONTROL_DEMANDS, DEFAULT_CELLS, chosen, controls, unmatched
from bench.gate.given import unpacked
from bench.gate.judged import fails, judge_cell, judge_new
from bench.gate.prober import Prober
from bench.gate.record import CONTROL, GateCell
from bench.gate.side import Died, Refused
from bench.judging.question import Answers, Question, Unanswered, questions


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
    of_base = {cell.name: cell for cell in chosen(base.cells, patterns)}
    of_head = {cell.name: cell for cell in chosen(head.cells, patterns)}
    there = [*base.cells, *head.cells]
    for pattern in patterns:
        if not chosen(there, [pattern]) and (pattern not in DEFAULT_CELLS or not (of_base or of_head)):
            raise UnknownName(unmatched(there, pattern))
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
        _of_vehicle(examined, (base, head), name, cells)
    return examined


def _of_vehicle(
    examined: Examined, sides: tuple[Prober, Prober], name: str, cells: Sequence[GateCell]
) -> None:
    """Judge a vehicle's cells, all of which head has, and put them to what is examined."""
    base, head = sides
    known = any(name == vehicle for vehicle, *_ in base.cells)
    before = vehicle_of(base, name) if known else None
    try:
        now = vehicle_of(head, name)
    except Refused as reason:  # base loaded the vehicle just now, or never had it: head's file is broken
        for cell in cells:
            fails(cell, str(reason))
        examined.cells.extend(cells)
        return
    asked = questions(demand_sets(before or now), partial(_ask, base))
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
