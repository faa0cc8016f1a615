"""The allocator f = G tau + N z with the shortest z that respects the limits (eq. 4-5)."""

from math import nan
from operator import mul

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    Allocation,
    BoolArray,
    FloatArray,
    Status,
    StatusArray,
    answer,
    checked,
    checked_many,
)
from alloc.errors import NotApplicable
from alloc.formulations.hard import FORMULATION as HARD
from alloc.nullspace.batch import nearest_many
from alloc.nullspace.region import prepare, steps_bound
from alloc.nullspace.structure import Structure, decompose
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, limits_of

TOLERANCE = 1e-9
"""Excess over a limit that still counts as met, relative to the largest limit [-]: far above rounding (1e-16
times a condition number below 1e3), far below anything a thruster resolves. A demand outside the attainable
set by less is SOLVED: its thrusts are moved onto the limits, and the wrench errs by that much. Where the
null space moves one thruster of a block 1e6 times less than another, rounding weighs 1e6 times more, and a
demand this close to the edge may be called infeasible; in shipped vehicles that ratio stays below 4."""


class Nullspace:
    """The allocator; ``Allocation.iterations`` counts the elementary steps of a call.

    Attributes
    ----------
    worst_case_steps : steps that no demand can exceed
    """

    formulation = HARD.name
    limited = True
    tolerance = TOLERANCE

    def __init__(self, vehicle: Vehicle, structure: Structure, tolerance: float) -> None:
        """Precompute all that depends on the vehicle."""
        self.G = structure.G
        self._k, self._n = vehicle.k, vehicle.n
        self._unreachable = structure.unreachable if len(structure.unreachable) else None
        self._vehicle = vehicle
        self._limits_of_call = at_call(vehicle)
        self._slack = tolerance * vehicle.f_scale
        self._limits = list(zip(vehicle.f_min.tolist(), vehicle.f_max.tolist(), strict=True))
        self._fixed = structure.fixed.tolist()
        self._blocks = [
            (block.rows.tolist(), block.N.tolist(), prepare(block.N, self._slack))
            for block in structure.blocks
        ]
        self.worst_case_steps = vehicle.n + sum(region.worst_case_steps for _, _, region in self._blocks)

    def __call__(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits, which stand in right-hand sides only."""
        wrench = checked(tau, self._k)
        limits = self._limits
        if f_min is not None or f_max is not None:
            lows, highs = self._limits_of_call(f_min, f_max)
            limits = list(zip(lows.tolist(), highs.tolist(), strict=True))
            for low, high in limits:
                if low > high:
                    return self._infeasible(0)
        if self._unreachable is not None and np.abs(self._unreachable.dot(wrench)).max() > TOLERANCE:
            return self._infeasible(0)
        return self.within(wrench, limits)

    def within(self, wrench: FloatArray, limits: list[tuple[float, float]]) -> Allocation:
        """Allocate one wrench (k,) that the thrusters can push, inside pairs of f_min <= f_max [N]."""
        f = self.G.dot(wrench)
        thrusts = f.tolist()
        for x, (low, high) in zip(thrusts, limits, strict=True):
            if not low <= x <= high:
                break
        else:
            return answer(f, Status.SOLVED, self._n)
        steps = self._n
        for i in self._fixed:
            low, high = limits[i]
            if not low - self._slack <= thrusts[i] <= high + self._slack:
                return self._infeasible(steps)
        for rows, N, region in self._blocks:
            z, taken = region.nearest(
                [limits[i][0] - thrusts[i] for i in rows], [limits[i][1] - thrusts[i] for i in rows]
            )
            steps += taken
            if z is None:
                return self._infeasible(steps)
            for i, row in zip(rows, N, strict=True):
                thrusts[i] += sum(map(mul, row, z))
        # Rounding, or a demand outside the attainable set within TOLERANCE, leaves thrusts beyond a limit.
        for i, (low, high) in enumerate(limits):
            x = thrusts[i]
            if not low <= x <= high:
                thrusts[i] = low if x < low else high
        return answer(np.array(thrusts), Status.SOLVED, steps)

    def many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches, all demands side by side."""
        wrenches = checked_many(taus, self._k)
        lows, highs = limits_of(self._vehicle, len(wrenches), f_min, f_max)
        F, met = self.many_within(wrenches, lows, highs)
        met &= (lows <= highs).all(axis=1)
        if self._unreachable is not None:
            met &= (np.abs(self._unreachable @ wrenches.T) <= TOLERANCE).all(axis=0)
        F[~met] = np.nan
        return F, np.where(met, Status.SOLVED, Status.INFEASIBLE).astype(np.int8)

    def many_within(
        self, wrenches: FloatArray, lows: FloatArray, highs: FloatArray
    ) -> tuple[FloatArray, BoolArray]:
        """``within`` for wrenches (N, k) and limits (N, n): F (N, n) [N], and (N,) which are attainable."""
        f = self.G @ wrenches.T
        lower, upper = lows.T - f, highs.T - f
        met = ((lower[self._fixed] <= self._slack) & (upper[self._fixed] >= -self._slack)).all(axis=0)
        for rows, N, region in self._blocks:
            z, feasible = nearest_many(region, lower[rows], upper[rows])
            f[rows] += np.asarray(N) @ z
            met &= feasible
        return f.T.clip(lows, highs), met

    def _infeasible(self, steps: int) -> Allocation:
        return answer(np.full(self._n, nan), Status.INFEASIBLE, steps)


STEPS_LIMIT = 5000
"""Largest worst case of a block, in steps. Up to here a call may take milliseconds in Python and setting up
a tenth of a second (measured on one x86-64 core, 3 x 11); an active-set solver needs neither."""


def exact(vehicle: Vehicle, tolerance: float = TOLERANCE) -> Nullspace:
    """Prepare the exact answer; raises NotApplicable where a block may take more than STEPS_LIMIT steps.

    ``tolerance`` is the excess over a limit that still counts as met, relative to the largest limit [-].
    """
    structure = decompose(vehicle)
    for block in structure.blocks:
        m, d = block.N.shape
        if (bound := steps_bound(m, d)) > STEPS_LIMIT:
            raise NotApplicable(
                f"nullspace: {m} thrusters share a {d}-dimensional null space, up to {bound} steps a call; "
                f"more than {STEPS_LIMIT} are refused, use a qp/ method"
            )
    return Nullspace(vehicle, structure, tolerance)
