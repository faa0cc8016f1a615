"""Demands with the right answers to them, made once a run and handed to the workers."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import (
    AllocError,
    BoolArray,
    FloatArray,
    Formulation,
    Label,
    Status,
    StatusArray,
    Vehicle,
    build,
    generalized_inverse,
    list_formulations,
)
from alloc.closed_forms.linear import Linear
from bench.demands import DemandSet
from bench.demands.store import arrays_of_demands, demands_of, save

UNLIMITED = Linear.formulation


@dataclass(frozen=True, eq=False)
class Question:
    """Demands on a vehicle, and what each formulation must answer.

    Attributes
    ----------
    demands : what is asked, of which vehicle
    right : formulation to (N, n) right answers [N], rows of NaN where none is known
    reference : formulation to the method that gave them; a worker need not know
    """

    demands: DemandSet
    right: dict[str, FloatArray]
    reference: dict[str, str]

    def save(self, path: Path) -> None:
        """Write demands and right answers into one .npz file."""
        answers = {f"right {name}": F for name, F in self.right.items()}
        save(path, **arrays_of_demands(self.demands), **answers)

    @classmethod
    def load(cls, path: Path) -> "Question":
        """Read what ``save`` wrote."""
        with np.load(path) as arrays:
            right = {f.name: arrays[f"right {f.name}"] for f in list_formulations()}
            return cls(demands_of(arrays), right, {})


class Answers(NamedTuple):
    """What a method answered to a case: thrusts F (N, n) [N] and statuses (N,)."""

    F: FloatArray
    status: StatusArray


class Unanswered(NamedTuple):
    """Why a case has no answers: a cell's status (failed, crashed, timeout, missing, refused) and reason."""

    status: str
    reason: str


Case = tuple[Vehicle, FloatArray]
"""A vehicle, and demands (N, k) on it."""
Ask = Callable[[str, Sequence[Case]], list[Answers | Unanswered]]
"""A method's name and cases to what it answered to each, wherever it runs."""


def ask_here(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
    """An ``Ask`` in this process, which a method that crashes or hangs would take with it."""
    said: list[Answers | Unanswered] = []
    for vehicle, taus in cases:
        try:
            said.append(Answers(*build(method, vehicle).many(taus)))
        except AllocError as error:
            said.append(Unanswered("refused", str(error)))
    return said


def questions(sets: Sequence[DemandSet], ask: Ask) -> list[Question]:
    """Each demand set with the right answers of every formulation, worked out by its reference methods.

    Where T* tau lies inside the limits it is the optimum, so closed forms and QPs are held to the same
    numbers there.
    """
    made = [Question(d, {UNLIMITED: d.taus @ generalized_inverse(d.vehicle).T}, {}) for d in sets]
    for asked in (f for f in list_formulations() if f.name != UNLIMITED):
        lacking = made
        for method in asked.references if made else ():
            cases = [(q.demands.vehicle, asked.asked(q.demands.vehicle, q.demands.taus)) for q in lacking]
            for question, answers in zip(lacking, ask(method, cases), strict=True):
                if isinstance(answers, Answers):
                    question.right[asked.name] = _right(asked, question, answers)
                    question.reference[asked.name] = method
            lacking = [question for question in lacking if asked.name not in question.right]
            if not lacking:
                break
        for question in lacking:  # its rows are then judged by limits, wrench and certificates alone
            question.right[asked.name] = np.full_like(question.right[UNLIMITED], np.nan)
    return made


def _right(asked: Formulation, question: Question, answers: Answers) -> FloatArray:
    given = answers.status == Status.SOLVED
    if asked.gives_way:
        given |= answers.status == Status.PARTIAL
    F = np.where(given[:, None], answers.F, np.nan)
    if not asked.optimal:
        return F
    return np.where(_inactive(question)[:, None], question.right[UNLIMITED], F)


def right_answers(question: Question, name: str) -> FloatArray:
    """(N, n) what the formulation of that name must answer [N]; rows of NaN where nothing is said.

    A rule of practice has no optimum of its own, but nothing to do while T* tau lies inside the limits:
    there it must return that.
    """
    if name in question.right:
        return question.right[name]
    return np.where(_inactive(question)[:, None], question.right[UNLIMITED], np.nan)


def _inactive(question: Question) -> BoolArray:
    return np.equal(question.demands.labels, Label.INACTIVE)
