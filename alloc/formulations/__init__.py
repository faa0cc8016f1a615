"""What a right answer is. One file, one formulation, found by its file name; each holds one FORMULATION.

"QP" means several different optima in published allocators, so a method names the one it answers, and
answers are compared only within one. Whoever judges, draws or ranks answers asks the formulation.
"""

import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from importlib import import_module

from alloc.allocation import FloatArray
from alloc.qp import Posed
from alloc.vehicle import Vehicle


class Family(StrEnum):
    """Kinds of methods that reports show together."""

    CLOSED_FORM = "closed form, no limits"
    PRACTICE = "practice behind a closed form"
    EXACT = "exact closed form"
    LIVE = "QP solver, live"
    ONE_SHOT = "QP solver, one shot"
    SOFT = "soft QP"


EXACT_METHODS = ("nullspace", "qp/daqp", "qp/clarabel")
"""Methods that can give the optimum of eq. 4-5, best first: up to rounding, active set, interior point."""


def as_they_are(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """The demands themselves."""
    return taus


@dataclass(frozen=True, kw_only=True)
class Formulation:
    """One question that an allocator may answer.

    Attributes
    ----------
    name : as a method's module and an allocator's ``formulation`` say it
    title : what the answer is, in a table's few words
    meaning : what the answer is, as the end of a sentence that starts with the name
    family : of a method that answers it and says nothing else of its family
    limited : whether f is promised to lie inside the limits
    optimal : whether every attainable demand is met at least effort, so that answers may be called exact
    gives_way : whether a wrench that could be met may be met in part: SOLVED then says nothing of the wrench
    references : methods that can give the right answers, best first; empty where there are none but T* tau
        on inactive demands
    asked : (vehicle, taus (N, k)) to the demands (N, k) whose answer by a reference is the right one
    pose : the vehicle's problem as a QP, whose duality gap certifies an answer; None where it is none
    """

    name: str
    title: str
    meaning: str
    family: Family
    limited: bool
    optimal: bool = False
    gives_way: bool = False
    references: tuple[str, ...] = ()
    asked: Callable[[Vehicle, FloatArray], FloatArray] = as_they_are
    pose: Callable[[Vehicle], Posed] | None = None


@cache
def list_formulations() -> tuple[Formulation, ...]:
    """Every formulation there is a file for, sorted by name."""
    modules = (import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__))
    found: list[Formulation] = [module.FORMULATION for module in modules]
    return tuple(sorted(found, key=lambda formulation: formulation.name))


def find_formulation(name: str) -> Formulation:
    """The formulation of that name; any other name is that of a rule of practice.

    A rule has no optimum of its own, but nothing to do while T* tau lies inside the limits: there it must
    return that.
    """
    for known in list_formulations():
        if known.name == name:
            return known
    return Formulation(
        name=name,
        title="a rule within limits",
        meaning="is a rule of practice",
        family=Family.PRACTICE,
        limited=True,
    )
