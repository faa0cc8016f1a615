"""Answers to other forms of calls that the contract allows, compared with those before."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bench.demands import DemandSet
from bench.demands.store import Case
from bench.gate.answers import HANGS_S, SideAnswers, apart_allowed, calls
from bench.gate.prober import Prober
from bench.gate.record import GateCell
from bench.gate.side import NO_REPLY, Died, Refused
from bench.judging.question import Question

CALLS = 20
"""How many demands each form is asked."""


def ask_forms(
    cell: GateCell,
    sides: tuple[Prober, Prober],
    questions: tuple[Question, Question],
    whole: tuple[SideAnswers, SideAnswers],
) -> None:
    """Ask both sides for other forms of calls: what base answers as it does the usual ones, head must.

    ``whole`` is what they answered to ``questions``.
    """
    base, head = (
        wrong_forms(side, cell, question.demands, answers.promises)
        for side, question, answers in zip(sides, questions, whole, strict=True)
    )
    for form, what in head.items():
        if what:
            cell.head_wrong = cell.head_wrong or f"{form}: {what}"
            cell.turned_wrong = cell.turned_wrong or ("" if base.get(form) else f"{form}: {what}")
    cell.base_wrong = cell.base_wrong or one_of(base)


def one_of(forms: Mapping[str, str]) -> str:
    """The first form that is wrong, and how; empty where none is."""
    return next((f"{form}: {what}" for form, what in forms.items() if what), "")


def wrong_forms(
    side: Prober, cell: GateCell, demands: DemandSet, promises: Mapping[str, Any]
) -> dict[str, str]:
    """Errors of each form of calls, by name; a form that a side does not have is left out."""
    vehicle, taus = demands.vehicle, demands.taus[:: max(1, len(demands.taus) // CALLS)]
    half = (np.tile(side / 2, (len(taus), 1)) for side in (vehicle.f_min, vehicle.f_max))
    try:
        asked = calls(Case(vehicle, taus, *half))
        raw = side.ask("forms", cell=cell.name, timeout=HANGS_S, **asked)
    except Died as reason:
        return {} if NO_REPLY in str(reason) else {"other forms of calls": str(reason)}
    except Refused as reason:
        lost = reason.kind == KeyError.__name__  # its process ended meanwhile
        return {} if lost else {"other forms of calls": str(reason)}
    allowed = apart_allowed(promises, vehicle)
    found = {}
    for form, held in raw.items():
        apart = held.get("apart", 0.0)
        found[form] = f"thrusts {apart:.3g} N from those of usual calls" if apart > allowed else ""
        if not held.get("same", True):
            found[form] = "another status than of usual calls"
        if "raises" in held:
            found[form] = f"raises {held['raises']}"
    return found
