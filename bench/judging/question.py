"""Demands with their right answers, made once a run and handed to the workers."""

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from alloc import AllocError, Label, NotApplicable, Status, Vehicle, build
from alloc.allocation import FloatArray, StatusArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.discovery import PROMISES
from alloc.errors import UnknownName
from alloc.formulations import (
    EndOf,
    Formulation,
    find_formulation,
    list_formulations,
    mixed,
    refuse_misspelt,
)
from alloc.formulations.hard import FORMULATION as HARD
from alloc.formulations.unlimited import FORMULATION as UNLIMITED
from bench.demands import DemandSet
from bench.demands.store import Case, pack_demands, save, unpack_demands, unpack_vehicle


@dataclass(frozen=True, eq=False)
class Question:
    """Demands on a vehicle, and what each formulation must answer.

    Attributes
    ----------
    demands : what is asked, of which vehicle
    right : (N, n) right answers by formulation [N], rows of NaN where none is known
    reference : the method that gave them, by formulation; not saved, because no worker needs it
    """

    demands: DemandSet
    right: dict[str, FloatArray]
    reference: dict[str, str]

    def save(self, path: Path) -> None:
        """Write demands and right answers into one .npz file."""
        right = {f"right {name}": F for name, F in self.right.items()}
        save(path, **pack_demands(self.demands), **right)

    @property
    def timed(self) -> "Question":
        """The part of the question that is timed: all of it, but of a mission that is judged whole."""
        return self if self.demands.part is None else self.rows(slice(*self.demands.part))

    def rows(self, rows: slice) -> "Question":
        """The question of those of its demands alone."""
        names = ("taus", "labels", "alpha", "hard_labels", "hard_alpha", "f_min", "f_max", "f_previous")
        whole: dict[str, Any] = {name: getattr(self.demands, name) for name in names}
        cut: dict[str, Any] = {name: array[rows] for name, array in whole.items() if array is not None}
        demands = replace(self.demands, **cut, part=None, gaps=())
        return Question(demands, {name: F[rows] for name, F in self.right.items()}, self.reference)

    @classmethod
    def load(cls, path: Path) -> tuple["Question", Vehicle]:
        """Read what ``save`` wrote, and its vehicle once more, of arrays of its own."""
        with np.load(path) as stored:
            arrays = dict(stored)
        right = {name[6:]: array for name, array in arrays.items() if name.startswith("right ")}
        own = unpack_vehicle({name: array.copy() for name, array in arrays.items()})
        return cls(unpack_demands(arrays), right, {}), own


class Answers(NamedTuple):
    """Answers of a method to a case.

    Attributes
    ----------
    F : (N, n) thrusts [N]
    status : (N,) values of ``alloc.Status``
    promises : formulation, limited and tolerance of the allocator, by name; empty where nobody asked for them
    """

    F: FloatArray
    status: StatusArray
    promises: Mapping[str, Any] = MappingProxyType({})


PROMISED = ("a name", "True or False", "a number from 0 on")
"""Values that each of these may have."""


def check_promises(given: Mapping[str, Any]) -> dict[str, Any]:
    """The promises as plain values; raises ValueError for one that no answer could be held to."""
    promises = {name: np.asarray(given[name]) for name in PROMISES}
    for name, kinds, wanted in zip(PROMISES, ("U", "b", "fiu"), PROMISED, strict=True):
        value = promises[name]
        # NaN can't be recorded, and no answer would be within it.
        if value.shape or value.dtype.kind not in kinds or (name == "tolerance" and not 0 <= value < inf):
            raise ValueError(f"{name} {given[name]!r} promises nothing; give {wanted}")
    try:
        refuse_misspelt(promises["formulation"].item())
    except UnknownName as error:
        raise ValueError(str(error)) from None
    return {name: value.item() for name, value in promises.items()}


def read_promises(allocator: Any) -> dict[str, Any]:
    """Promises of an allocator, checked."""
    return check_promises({name: getattr(allocator, name) for name in PROMISES})


class Unanswered(NamedTuple):
    """Reason why a case has no answers.

    Attributes
    ----------
    status : as in ``bench.record.Cell``: failed, crashed, timeout, missing or refused
    reason : the reason, in words
    """

    status: str
    reason: str


Ask = Callable[[str, Sequence[Case]], list[Answers | Unanswered]]
"""A function of a method's name and cases, which returns what the method answered to each case."""


def ask_here(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
    """An ``Ask`` that runs the method in this process; a method that crashes or hangs takes it along."""
    answers: list[Answers | Unanswered] = []
    for case in cases:
        try:
            answers.append(Answers(*build(method, case.vehicle).many(case.taus, case.f_min, case.f_max)))
        except AllocError as error:
            answers.append(Unanswered("refused", str(error)))
    return answers


def questions(
    sets: Sequence[DemandSet], ask: Ask, formulations: Container[str] | None = None
) -> list[Question]:
    """Each demand set with the right answers of every formulation, as the formulation's references give them.

    Where T* tau lies inside the limits it is the optimum, so closed forms and QPs are held to the same
    numbers there. ``formulations`` are the names of those that somebody answers: the references of others
    are not asked, but for the hard optimum, which losses are counted against.
    """
    made = [Question(d, {UNLIMITED.name: d.taus @ generalized_inverse(d.vehicle).T}, {}) for d in sets]
    for formulation in list_formulations():
        answered = formulations is None or formulation.name in formulations or formulation.name == HARD.name
        if formulation.name != UNLIMITED.name and answered:
            _ask_references(formulation, made, ask)
    return made


def _ask_references(formulation: Formulation, made: list[Question], ask: Ask) -> None:
    """Add the formulation's right answers to each question, from the first reference that answers it."""
    name = formulation.name
    pending = [(q, cases) for q in made if (cases := _reference_cases(formulation, q.demands))]
    for method in formulation.references:
        if not pending:
            break
        replies = iter(ask(method, [case for _, cases in pending for case in cases]))
        for question, cases in pending:
            right = _right(formulation, question, [next(replies) for _ in cases])
            if right is not None:
                question.right[name], question.reference[name] = right, method
        pending = [(question, cases) for question, cases in pending if name not in question.right]
    for question in made:  # without right answers, judged by limits, wrench and certificates alone
        question.right.setdefault(name, np.full_like(question.right[UNLIMITED.name], np.nan))


def _reference_cases(formulation: Formulation, demands: DemandSet) -> list[Case]:
    """Cases for the references: one, or of each way two whose answers give those of a third (``EndOf``).

    Empty where the formulation does not say it of this vehicle, and under a cap, which no reference keeps.
    """
    if demands.supply.arguments:
        return []
    given = demands.taus, demands.f_min, demands.f_max
    asked = formulation.reference_demands
    try:
        each = (
            [
                (part.vehicle, taus)
                for part in formulation.parts(demands.vehicle)
                for taus in asked.twice(part.way, demands.vehicle, *given)
            ]
            if isinstance(asked, EndOf)
            else [(formulation.subject(demands.vehicle), asked(demands.vehicle, *given))]
        )
    except NotApplicable:
        return []
    return [Case(vehicle, taus, demands.f_min, demands.f_max) for vehicle, taus in each]


def _right(
    formulation: Formulation, question: Question, replies: Sequence[Answers | Unanswered]
) -> FloatArray | None:
    """Right answers (N, n) out of those to ``_reference_cases``; None where a reference has none."""
    taken = []
    for answers in replies:
        if not isinstance(answers, Answers):
            return None
        given = answers.status == Status.SOLVED
        if formulation.gives_way:
            given |= answers.status == Status.PARTIAL
        taken.append(np.where(given[:, None], answers.F, np.nan))
    F: FloatArray = taken[0]
    vehicle = question.demands.vehicle
    if len(taken) > 1:  # answers a little before an end, and twice as far before it
        pairs = zip(taken[::2], taken[1::2], strict=True)
        ends = [np.where(np.isfinite(2 * near - far), 2 * near - far, near) for near, far in pairs]
        F = mixed(ends, [part.w for part in formulation.parts(vehicle)])
    optimal = formulation.optimal_for(vehicle)
    return _closed_form_where_inactive(question, F, formulation) if optimal else F


def right_answers(question: Question, name: str) -> FloatArray:
    """(N, n) what the formulation of that name must answer [N]; rows of NaN where no right answer is known.

    A rule of practice has no optimum of its own, but it must return T* tau where that lies inside the limits.
    """
    if name in question.right:
        return question.right[name]
    return _closed_form_where_inactive(question, np.nan, find_formulation(name))


def _closed_form_where_inactive(
    question: Question, otherwise: FloatArray | float, formulation: Formulation
) -> FloatArray:
    demands, strong = question.demands, formulation.way is not None
    inactive = np.equal(demands.labels_for(strong=strong), Label.INACTIVE)
    closed = question.right[UNLIMITED.name]
    if strong and demands.hard_labels is not None:
        vehicle, taus = demands.strong
        closed = taus @ generalized_inverse(vehicle).T
    return np.where(inactive[:, None], closed, otherwise)
