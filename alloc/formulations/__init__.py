"""Formulations: each file defines one right answer as FORMULATION and is found by its file name.

An underscore in the file's name is a hyphen in the formulation's.

Published allocators mean several different optima by "QP", so a method names the formulation it answers,
and answers are compared only within one. Judging, drawing and ranking read the formulation's fields.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from enum import StrEnum
from functools import cache
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import UnknownName
from alloc.files.modules import modules
from alloc.qp import Posed
from alloc.reach.way import Levels, Way
from alloc.vehicle import Vehicle


class Family(StrEnum):
    """Kinds of methods that reports show together."""

    CLOSED_FORM = "closed form, no limits"
    PRACTICE = "practice behind a closed form"
    EXACT = "for an optimum, no QP solver"
    LIVE = "QP solver, live"
    GENERATED = "QP solver, its C"
    ONE_SHOT = "QP solver, one shot"
    SOFT = "soft QP"


EXACT_METHODS = ("nullspace", "qp/daqp", "qp/clarabel")
"""Methods that can give the optimum of eq. 4-5, best first: exact to rounding, active set, interior point."""


INWARD = 1e-12
"""Share by which the end of a way is moved back, so that rounding leaves it attainable [-]."""

ReferenceDemands = Callable[[Vehicle, FloatArray, FloatArray | None, FloatArray | None], FloatArray]
"""(vehicle, taus (N, k), f_min and f_max of each call (N, n) or None for the vehicle's) -> demands (N, k)."""


def as_they_are(
    vehicle: Vehicle, taus: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None
) -> FloatArray:
    """Return the demands themselves."""
    return taus


@dataclass(frozen=True)
class EndOf:
    """The wrenches that the way towards each demand reaches, moved back by the share INWARD.

    A ``reference_demands``; raises NotApplicable where the vehicle has no such way.
    """

    way: Callable[[Vehicle], Way]

    def __call__(
        self,
        vehicle: Vehicle,
        taus: FloatArray,
        f_min: FloatArray | None = None,
        f_max: FloatArray | None = None,
    ) -> FloatArray:
        """The demands that a reference is asked (N, k)."""
        return self.twice(self.way(vehicle), vehicle, taus, f_min, f_max)[0]

    @staticmethod
    def twice(
        through: Way, vehicle: Vehicle, taus: FloatArray, f_min: FloatArray | None, f_max: FloatArray | None
    ) -> tuple[FloatArray, FloatArray]:
        """Demands at the ends of a way, and others moved back twice as far.

        Thrusts are linear there, so that answers to both tell those of the ends themselves: near some edges
        they change thousands of times as much as the demand.
        """
        low = vehicle.f_min if f_min is None else f_min
        high = vehicle.f_max if f_max is None else f_max
        begin = through.departure(low, np.maximum(low, high))  # no answer is right where they contradict
        end, share = through.towards_many(taus, begin)
        stopped = (share < 1).any(axis=1, keepdims=True)
        back: FloatArray = np.where(stopped, INWARD * (begin.wrench - end), 0.0)
        return end + back, end + 2 * back


class Part(NamedTuple):
    """One way out of those whose answers are mixed, with its w and its vehicle (``Vehicle.mixture``).

    Attributes
    ----------
    level_indices : of each share of an answer, which level of the way it is of
    """

    w: float
    vehicle: Vehicle
    way: Way
    level_indices: list[int]


def mixed(answers: Sequence[FloatArray], ws: Sequence[float]) -> FloatArray:
    """x_0 + sum_j w_j (x_j - x_j-1), exactly x_0 where all are alike."""
    found = answers[0].copy()
    for before, one, w in zip(answers, answers[1:], ws[1:], strict=False):
        found += w * (one - before)
    return found


@dataclass(frozen=True, kw_only=True)
class Formulation:
    """One question that an allocator may answer.

    Attributes
    ----------
    name : named as FORMULATION by a method's module, and as ``formulation`` by its allocator
    title : what the answer is, in a few words for a table
    meaning : what the answer is, as the end of a sentence that starts with the name
    family : family of a method of this formulation whose module names none
    limited : whether f is promised to lie inside the limits
    optimal : whether every attainable demand is met at least effort, so that answers may be called exact
    gives_way : whether an attainable wrench may be met in part; SOLVED then says nothing about the wrench
    keeps_inside : whether T* tau is the answer wherever it lies inside the limits
    references : methods that can give the right answers, best first; empty where the only right answers
        known are T* tau, on inactive demands
    reference_demands : function of the vehicle, the demands and the limits of each that returns the demands
        (N, k) [N, N m] that a reference is asked
    way : function of a vehicle that returns the ``Way`` from thrusts at rest towards a demand, where answers
        say what share of each of its levels they deliver; None where there are no levels. Given levels, too,
        through these, where ``apart`` has several
    apart : function of a vehicle that returns the levels of its ways, each with its w, where answers of
        several ways are mixed; the first are those of ``way``
    reaches_all : function of a vehicle that returns whether every attainable demand is reached
    pose : function of a vehicle that returns its problem as a QP, whose duality gap certifies an answer, and
        takes ``shared`` where solvers answer it (``alloc.qp.problem``); None where the formulation is no QP
    """

    name: str
    title: str
    meaning: str
    family: Family
    limited: bool
    optimal: bool = False
    gives_way: bool = False
    keeps_inside: bool = True
    references: tuple[str, ...] = ()
    reference_demands: ReferenceDemands = as_they_are
    way: Callable[..., Way] | None = None
    apart: Callable[[Vehicle], Sequence[tuple[float, Levels]]] = lambda _: ((1.0, ()),)
    reaches_all: Callable[[Vehicle], bool] = lambda _: True
    pose: Callable[..., Posed] | None = None

    def subject(self, vehicle: Vehicle) -> Vehicle:
        """The vehicle whose wrench an answer is held to: of a formulation with a way its strong part.

        Of a vehicle with directions that count in part it is the one without them.
        """
        return vehicle.mixture[0][1] if self.way else vehicle

    def parts(self, vehicle: Vehicle) -> tuple[Part, ...]:
        """The ways whose answers are mixed: through each levels of ``apart``, of each ``Vehicle.mixture``."""
        assert self.way is not None
        apart, found = self.apart(vehicle), list[Part]()
        for i, (w, levels) in enumerate(apart):
            own = self.way(vehicle, levels) if i else self.way(vehicle)
            first = own if not i else found[0].way
            of = [next(j for j, axes in enumerate(own.levels) if level[0] in axes) for level in first.levels]
            less = w - (apart[i + 1][0] if i + 1 < len(apart) else 0.0)
            behind = w - less
            for v, each in vehicle.mixture:
                way = own
                if each is not vehicle.strong:
                    way = Way(each, own.levels, own.keep, together=own.together)
                found.append(Part(behind + less * v, each, way, of))
        return tuple(found)

    def mixes(self, vehicle: Vehicle) -> bool:
        """True if answers for this vehicle are mixed out of those of several ways."""
        return self.way is not None and (len(vehicle.mixture) > 1 or len(self.apart(vehicle)) > 1)

    def optimal_for(self, vehicle: Vehicle) -> bool:
        """True if answers are optimal for this vehicle too: groups that share thrusters take turns.

        A mixture of optima is none.
        """
        return self.optimal and not self.mixes(vehicle) and self.reaches_all(vehicle)


@cache
def list_formulations() -> tuple[Formulation, ...]:
    """Every formulation there is a file for, sorted by name."""
    formulations: list[Formulation] = [module.FORMULATION for module in modules(__name__).values()]
    return tuple(sorted(formulations, key=lambda formulation: formulation.name))


def find_formulation(name: str) -> Formulation:
    """The formulation of that name; a name without a file is that of a rule of practice.

    A rule of practice has no optimum of its own. While T* tau lies inside the limits there is nothing to
    mend, so its right answer there is T* tau.
    """
    for formulation in list_formulations():
        if formulation.name == name:
            return formulation
    return Formulation(
        name=name,
        title="a rule within limits",
        meaning="is a rule of practice",
        family=Family.PRACTICE,
        limited=True,
    )


def refuse_misspelt(name: str) -> None:
    """Raise UnknownName for a name that is one with a file but for a letter or its case, such as ``hrad``.

    Taken for a rule of practice, such a method would be held to no optimum.
    """
    if (close := nearly(name)) not in ("", name):
        raise UnknownName(
            f"the formulation {name[:60]!r} is a letter or two from '{close}';"
            " write that, or give a rule of your own another name"
        )


def nearly(name: str) -> str:
    """The formulation with a file that a name is, but for a letter or its case; empty where it is none."""
    known = [formulation.name for formulation in list_formulations()]
    if name in known:
        return name
    alike = [other for other in known if abs(len(other) - len(name)) <= 1]
    return next(iter(get_close_matches(name.lower(), alike, n=1, cutoff=0.75)), "")
