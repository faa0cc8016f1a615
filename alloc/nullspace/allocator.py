"""The allocator f = G tau + N z with the shortest z that respects the limits (eq. 4-5)."""

from math import inf, nan
from operator import mul

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    WRENCH_TOLERANCE,
    Allocation,
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
from alloc.vehicle.condition import condition, promised, wrench_doubt

TOLERANCE = 1e-9
"""Excess over a limit that still counts as met, relative to the largest limit [-]: far below anything a
thruster resolves, and above rounding unless T nearly loses rank, where it is what rounding leaves
(``alloc.vehicle.condition``). A demand outside the attainable set by less is SOLVED: its thrusts are moved
onto the limits, and the wrench errs by that much."""

LARGEST_DOUBT = WRENCH_TOLERANCE / 4
"""Largest excess that may count as met [-]: thrusts off by it, n up to 16, still meet a wrench."""

NEAR_EDGE = (1e-3, 1e3)
"""Excesses over a limit, in units of the one that counts as met, within which rounding might decide a
verdict: ``many`` then takes the verdict of a single call."""


class Nullspace:
    """The allocator; ``Allocation.iterations`` counts the elementary steps of a call.

    Attributes
    ----------
    worst_case_steps : steps that no demand can exceed
    """

    formulation = HARD.name
    limited = True

    def __init__(self, vehicle: Vehicle, structure: Structure, tolerance: float) -> None:
        """Precompute all that depends on the vehicle."""
        self.tolerance = promised(vehicle, TOLERANCE)
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
        """Allocate (N, k) wrenches, all demands side by side; a verdict is always that of a single call."""
        wrenches = checked_many(taus, self._k)
        lows, highs = limits_of(self._vehicle, len(wrenches), f_min, f_max)
        F, excess = self.many_within(wrenches, lows, highs)
        if self._unreachable is not None:
            excess = np.maximum(excess, np.abs(self._unreachable @ wrenches.T).max(axis=0) / TOLERANCE)
        excess[(lows > highs).any(axis=1)] = inf
        status = np.where(excess <= 1.0, Status.SOLVED, Status.INFEASIBLE).astype(np.int8)
        F[excess > 1.0] = np.nan
        for i in np.flatnonzero((excess > NEAR_EDGE[0]) & (excess < NEAR_EDGE[1])):
            F[i], status[i], *_ = self(wrenches[i], lows[i], highs[i])
        return F, status

    def many_within(
        self, wrenches: FloatArray, lows: FloatArray, highs: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """``within`` for wrenches (N, k) and limits (N, n): F (N, n) [N], and the excess over limits (N,).

        The excess is in units of what counts as met: up to 1 a wrench is attainable.
        """
        f = self.G @ wrenches.T
        lower, upper = lows.T - f, highs.T - f
        fixed = np.maximum(lower[self._fixed], -upper[self._fixed])
        excess = fixed.max(axis=0, initial=0.0) / self._slack
        for rows, N, region in self._blocks:
            z, beyond = nearest_many(region, lower[rows], upper[rows])
            f[rows] += np.asarray(N) @ z
            excess = np.maximum(excess, beyond)
        return f.T.clip(lows, highs), excess

    def _infeasible(self, steps: int) -> Allocation:
        return answer(np.full(self._n, nan), Status.INFEASIBLE, steps)


STEPS_LIMIT = 5000
"""Largest worst case of a block, in steps. Up to here a call may take milliseconds in Python and setting up
a tenth of a second (measured on one x86-64 core, 3 x 11); an active-set solver needs neither."""


def exact(vehicle: Vehicle, tolerance: float = TOLERANCE) -> Nullspace:
    """Prepare the exact answer.

    ``tolerance`` is the excess over a limit that still counts as met, relative to the largest limit [-], or
    what rounding leaves of it. Raises NotApplicable where that is too much for SOLVED to mean anything, and
    where a block may take more than STEPS_LIMIT steps.
    """
    if (doubt := wrench_doubt(vehicle)) > LARGEST_DOUBT:
        raise NotApplicable(
            f"{vehicle.name}: T nearly loses rank, condition {condition(vehicle):.2g}, so rounding alone "
            f"moves thrusts by {doubt:.1g} of the largest limit; leave out the weakest DOF, or use qp/daqp"
        )
    structure = decompose(vehicle)
    for block in structure.blocks:
        m, d = block.N.shape
        if (bound := steps_bound(m, d)) > STEPS_LIMIT:
            raise NotApplicable(
                f"nullspace: {m} thrusters share a {d}-dimensional null space, up to {bound} steps a call; "
                f"more than {STEPS_LIMIT} are refused, use a qp/ method"
            )
    return Nullspace(vehicle, structure, max(tolerance, doubt))
