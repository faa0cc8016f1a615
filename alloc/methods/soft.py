"""Weighted least squares within limits (Fossen 2021, eq. 11.38) by an active set, exact, no QP solver.

Which thrusters are free says by a table what each aims at: the thrust that it would take, were it free too.
Thrusts are optimal where each is its aim cut at the limits, and nothing else has to be compared.
"""

from math import inf, nan

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    EXACT_TOLERANCE,
    Allocation,
    BoolArray,
    FloatArray,
    Status,
    StatusArray,
    Uncapped,
    answer,
    checked,
)
from alloc.closed_forms.weighted import STEPS_PER_THRUSTER, aims, rounded
from alloc.errors import NotApplicable
from alloc.formulations.soft import FORMULATION as SOFT
from alloc.kernels import weighted as kernels
from alloc.kernels.rules import MEANINGS as RULE
from alloc.program import Program, Scalar, Where, states
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, one_by_one
from alloc.vehicle.condition import promised

FORMULATION = SOFT.name
MEANINGS = RULE | {
    0: "f is the optimum, and makes tau",
    1: "f is the optimum inside the limits, where a part of tau is not worth its effort or can't be had",
    3: "the steps that a call may take did not reach the optimum; f is left alone",
}
doubt = kernels.doubt
TABLE_THRUSTERS = 8
"""Up to this many thrusters ``build`` makes the rows of all sets of free ones (256). For more thrusters those
of a set are made at its first use, so that a first call may cost tens of later ones."""
MOST_THRUSTERS = 62
"""Sets of free thrusters are bits of signed 64-bit integers."""


class Soft(Uncapped):
    """The allocator; ``Allocation.iterations`` counts the steps of a call, each a product with a table.

    Attributes
    ----------
    worst_case_steps : steps that no call exceeds; one that would is NOT_CONVERGED
    """

    formulation = SOFT.name
    limited = True

    def __init__(self, vehicle: Vehicle) -> None:
        """Prepare the rows of all sets of free thrusters, up to TABLE_THRUSTERS."""
        self.tolerance = promised(vehicle, EXACT_TOLERANCE)
        self.worst_case_steps = 1 + STEPS_PER_THRUSTER * vehicle.n
        self._vehicle = vehicle
        self._limits_of_call = at_call(vehicle)
        self._per_axis = 1.0 / vehicle.wrench_scale
        self._bits = 1 << np.arange(vehicle.n)
        self._all = int(self._bits.sum())
        whole = np.arange(self._all, self._all + 1)
        free = np.arange(self._all + 1) if vehicle.n <= TABLE_THRUSTERS else whole
        rows = aims(vehicle, free)
        self._rounded = rounded(vehicle, rows, float(np.finfo(np.float64).eps))
        self._rows = dict(zip(free.tolist(), rows, strict=True))
        self._own = {each: self._of_own(row) for each, row in self._rows.items()}

    def _of_own(self, rows: FloatArray) -> FloatArray:
        """(n,) share of its own thrust that each thruster aims at, if that is all that is asked for [-]."""
        own: FloatArray = np.einsum("ik,ki->i", rows, self._vehicle.TP)
        return own

    def _aim(self, wrench: FloatArray, f: FloatArray, free: BoolArray) -> FloatArray:
        """(n,) thrust that each thruster would take, were it free beside those that are [N]."""
        mask = int(self._bits[free].sum())
        if mask not in self._rows:
            rows = aims(self._vehicle, np.array([mask]))[0]
            self._own[mask], self._rows[mask] = self._of_own(rows), rows
        held = np.where(free, 0.0, f)
        rest = wrench - self._vehicle.TP.dot(held)
        aim: FloatArray = self._rows[mask].dot(rest) + self._own[mask] * held
        return aim

    def allocate(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits (n,) [N]; every wrench has an answer.

        SOLVED where T P f = tau within EXACT_TOLERANCE, which the penalty allows next to zero only.
        """
        wrench = checked(tau, self._vehicle.k)
        low, high = self._limits_of_call(f_min, f_max)
        if (low > high).any():
            return self._unanswered(Status.INFEASIBLE)
        f, steps = self._optimum(wrench, low, high)
        if f is None:
            return self._unanswered(Status.NOT_CONVERGED, steps)
        missed = np.abs(self._vehicle.TP.dot(f) - wrench) * self._per_axis
        return answer(f, Status.SOLVED if missed.sum() <= EXACT_TOLERANCE else Status.PARTIAL, steps)

    def _optimum(
        self, wrench: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray | None, int]:
        """Thrusts each of which is its aim cut at the limits, and the steps taken; None beyond the last.

        From the cut aims of all, each step goes towards the aims of the free ones: up to the first limit in
        the way, whose thruster is then held there, or all the way, and then frees the held one that is
        farthest from its aim. The cost falls with each step, so none leads back.
        """
        free = np.ones(len(low), dtype=bool)
        aim = self._aim(wrench, low, free)
        f = aim.clip(low, high)
        size = self._vehicle.f_scale * (1.0 + np.abs(wrench * self._per_axis).max()) + np.abs(f).max()
        slack = self._rounded * size
        free = np.abs(aim - f) <= slack
        if free.all():
            return f, 1
        for step in range(2, self.worst_case_steps + 1):
            aim = self._aim(wrench, f, free)
            cut = aim.clip(low, high)
            beyond = free & ~(np.abs(aim - cut) <= slack)
            if beyond.any():
                share = np.full(len(f), inf)
                share[beyond] = (cut - f)[beyond] / (aim - f)[beyond]
                first = int(share.argmin())
                f = np.where(free, f + share[first] * (aim - f), f).clip(low, high)
                f[first], free[first] = cut[first], False
                continue
            f = np.where(free, cut, f)
            away = np.abs(cut - f)
            last = int(away.argmax())
            if away[last] <= slack:
                return f, step
            free[last] = True
        return None, self.worst_case_steps

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches one after the other."""
        return one_by_one(self, self._vehicle, taus, f_min, f_max)

    def _unanswered(self, status: Status, steps: int = 0) -> Allocation:
        return answer(np.full(self._vehicle.n, nan), status, steps)


def build(vehicle: Vehicle) -> Soft:
    """Prepare the active set; raises NotApplicable where H is not diagonal."""
    if vehicle.n > MOST_THRUSTERS:
        raise NotApplicable(f"soft covers up to {MOST_THRUSTERS} thrusters; {vehicle.name} has {vehicle.n}")
    return Soft(vehicle)


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same from a table in the C; raises NotApplicable where that would be too large."""
    return kernels.weighted(vehicle, limits, scalar)


def program_for_all(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """One program for the vehicle and all faults."""
    return kernels.weighted(vehicle, limits, scalar, states(vehicle))
