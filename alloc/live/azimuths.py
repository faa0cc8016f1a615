"""Allocators of vehicles whose thrusters turn: the best of all combinations of pieces, with angles."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    EXACT_TOLERANCE,
    Allocation,
    Allocator,
    FloatArray,
    Status,
    StatusArray,
    answer,
    checked,
)
from alloc.errors import DemandError, NotApplicable
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import polar
from alloc.vehicle.call_limits import at_call, one_by_one
from alloc.vehicle.limits import Interval
from alloc.vehicle.moment import Sets
from alloc.vehicle.pieces import combinations, join

OFFERED = ("pose", "solve", "worst_case_steps")
"""Parts of an allocator by which its kind is told (``alloc.plugin.TwoStage``, ``BoundedSteps``)."""
EFFORT_MARGIN = 0.1
"""Share of the least effort that another combination of pieces must save to take the last one's place [-]."""
SHARE_MARGIN = 0.01
"""Share of the demand that another combination must deliver more, where none delivers all [-]."""
NEAR = 1e-6
"""Share of the largest limit by which a last force may lie outside of a piece and be from it [-]."""


def with_angles(vehicle: Vehicle, given: Allocation) -> Allocation:
    """An answer with ``forces`` and ``angles`` out of its ``f``, and the ``middles`` of sectors."""
    said = polar(vehicle.azimuths, vehicle.actuators, given.f.tolist(), vehicle.f_scale)
    forces, angles, middles = map(np.array, said)
    return given._replace(forces=forces, angles=angles, middles=middles)


class AzimuthAllocator:
    """An allocator of a vehicle whose thrusters turn: a method's answers, with forces and angles.

    Where sets of forces have several convex pieces the method has an allocator for each combination, and the
    best answer counts. SOLVED goes before PARTIAL, then more of the demand (shares, level by level; without
    shares the smaller miss), then less effort f'Hf. With thrusts of the last call the combinations that they
    may be from stay, unless another saves EFFORT_MARGIN of the effort, delivers SHARE_MARGIN more of the
    demand, or delivers all of it where they don't.
    """

    def __init__(self, make: Callable[[Vehicle], Allocator], vehicle: Vehicle, compiled: str = "") -> None:
        """Prepare the allocators that ``make`` returns of convex vehicles; ``compiled`` names a C method."""
        self._make, self._compiled = make, compiled
        self._vehicle, first = vehicle, make(combinations(vehicle)[0])
        self._own_limits = at_call(vehicle)  # those of a piece are others
        others = combinations(vehicle)[1:] if first.limited else ()
        self._allocators = [first, *(make(one) for one in others)]
        self._is_alone = bool(compiled) and not others
        self.formulation, self.limited = first.formulation, first.limited
        self.tolerance = max(each.tolerance for each in self._allocators)
        self.many: Any = self._many if others else getattr(first, "many", None)
        if not others:
            self.__dict__ |= {name: getattr(first, name) for name in OFFERED if hasattr(first, name)}

    def __call__(
        self,
        tau: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        f_previous: ArrayLike | None = None,
        limits: Interval | None = None,
        **given: Any,
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] as the method does, and say forces and angles.

        ``f_previous`` are the thrusts of the last call (n,) [N]; NaN where that had no answer. ``limits`` are
        sets of the moment, as ``vehicle.limits`` gives them, for which the method is prepared in the call.
        """
        if self._is_alone and f_previous is limits is f_min is f_max is None and not given:
            return self._allocators[0](tau)  # compiled C says forces and angles itself
        if limits is not None:
            if not isinstance(limits, Sets) or len(limits[0]) != self._vehicle.n:
                raise DemandError("limits are no sets of thrusters that turn; give vehicle.limits(…)")
            if self._compiled:
                raise NotApplicable(
                    f"{self._compiled}: takes no limits= yet, for which a method is prepared in the call; use"
                    f" {self._compiled.partition('@')[0]}"
                )
            checked(tau, self._vehicle.k)
            if limits.empty:
                nothing = answer(np.full(self._vehicle.n, np.nan), Status.INFEASIBLE)
                return with_angles(self._vehicle, nothing)
            at_once = AzimuthAllocator(self._make, with_sets(self._vehicle, limits))
            found = at_once(tau, f_min, f_max, f_previous=f_previous, **given)
            return with_angles(self._vehicle, found)
        last = None if f_previous is None else self._checked(f_previous)
        if len(self._allocators) == 1:
            boxes = () if f_min is None and f_max is None else (f_min, f_max)
            found = self._allocators[0](tau, *boxes, **given)
        else:
            self._own_limits(f_min, f_max)
            answers = [allocate(tau, **given) for allocate in self._allocators]
            stays = (
                range(0) if last is None or np.isnan(last).any() else last_combinations(self._vehicle, last)
            )
            found = best_answer(self._vehicle, np.asarray(tau, dtype=np.float64), answers, stays)
        if isinstance(found, Allocation) and np.shape(found.f) == (self._vehicle.n,):
            return with_angles(self._vehicle, found)
        return found  # a plug-in's answer that is none: what holds it to its promises says so

    def _checked(self, f_previous: ArrayLike) -> FloatArray:
        last, n = np.asarray(f_previous, dtype=np.float64), self._vehicle.n
        if last.shape != (n,) or np.isinf(last).any():
            raise DemandError(f"f_previous has shape {last.shape}; give ({n},), finite thrusts [N]")
        return last

    def _many(
        self,
        taus: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        **given: Any,
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches one after the other, none with the thrusts of another."""
        return one_by_one(self, self._vehicle, taus, f_min, f_max, **given)


def last_combinations(vehicle: Vehicle, last: FloatArray) -> Sequence[int]:
    """Indices of the ``combinations`` whose pieces the last thrusts (n,) may be from: the nearest ones."""
    near = []
    for azimuth in vehicle.turning:
        f = last[azimuth.components]
        beyond = np.array([max((part.normals @ f - part.reach).max(), 0.0) for part in azimuth.parts])
        near.append(beyond <= beyond.min() + NEAR * vehicle.f_scale)
    return np.flatnonzero([all(chosen) for chosen in product(*near)]).tolist()


def best_answer(
    vehicle: Vehicle, tau: FloatArray, answers: Sequence[Allocation], stays: Sequence[int]
) -> Allocation:
    """The best of answers of all combinations, or of those that ``stays`` names where that is near enough.

    Its iterations and its solver's time are those of all answers together.
    """
    iterations = sum(one.iterations for one in answers)
    solver_s = sum(one.solver_s for one in answers)
    found = [i for i, one in enumerate(answers) if one.found]
    if not found:
        worst = max(answers, key=lambda one: one.status)  # NOT_CONVERGED is above INFEASIBLE
        return worst._replace(iterations=iterations, solver_s=solver_s)
    status = min(answers[i].status for i in found)
    left = [i for i in found if answers[i].status == status]
    delivered = {i: _delivered(vehicle, tau, answers[i]) for i in left}
    efforts = {i: float(answers[i].f @ vehicle.H @ answers[i].f) for i in left}
    kept = [i for i in left if i in {*stays}]
    for level in range(len(delivered[left[0]])):
        most = max(delivered[i][level] for i in left)
        left = [i for i in left if delivered[i][level] >= most - EXACT_TOLERANCE]
        kept = [i for i in kept if delivered[i][level] >= most - SHARE_MARGIN]
    best = min(left, key=efforts.__getitem__)
    kept = [i for i in kept if efforts[i] <= (1.0 + EFFORT_MARGIN) * efforts[best]]
    if kept and best not in kept:
        best = min(kept, key=efforts.__getitem__)
    return answers[best]._replace(iterations=iterations, solver_s=solver_s)


def _delivered(vehicle: Vehicle, tau: FloatArray, given: Allocation) -> tuple[float, ...]:
    """Shares of an answer; of one without shares 1 less what it misses of the demand, 1 where SOLVED."""
    if given.share or given.status == Status.SOLVED:
        return given.share or (1.0,)
    asked = float(np.linalg.norm(tau / vehicle.wrench_scale))
    missed = float(np.linalg.norm((vehicle.TP @ given.f - tau) / vehicle.wrench_scale))
    return (1.0 - missed / asked,) if asked > 0.0 else (-missed,)


def with_sets(vehicle: Vehicle, sets: Sets) -> Vehicle:
    """The vehicle of a moment, whose own limits are these sets; raises NotApplicable where some are weak.

    Directions of wrench are weak by what the vehicle can do, not by what a moment leaves of it.
    """
    if vehicle.strong is not vehicle or len(vehicle.mixture) > 1:
        raise NotApplicable(f"{vehicle.name}: has weak directions, and limits= takes none yet; set weak: 0")
    azimuths = [
        azimuth if not vehicle.readiness[azimuth.first] else join(azimuth.first, pieces, None, azimuth.place)
        for azimuth, pieces in zip(vehicle.azimuths, sets.polygons, strict=True)
    ]
    return replace(
        vehicle, f_min=sets[0], f_max=sets[1], azimuths=tuple(azimuths), units=vehicle.row_lengths, slew=None
    )
