"""Least effort at the end of a way where thrusters turn and leave more dimensions than steps are taken in."""

import numpy as np

from alloc.allocation import EXACT_TOLERANCE, Allocation, FloatArray, Status
from alloc.closed_forms.inverse import generalized_inverse
from alloc.errors import NotApplicable
from alloc.formulations.hard import FORMULATION as HARD
from alloc.live.allocator import live
from alloc.nullspace.by_level import Exact, by_steps
from alloc.solvers import missing
from alloc.vehicle import Vehicle

SOLVER = "daqp"
"""An active-set solver, whose equations hold to rounding."""


def exact_by_any(vehicle: Vehicle) -> Exact:
    """The exact answer by steps, or where they are refused to thrusters that turn, by a QP solver.

    Raises NotApplicable where neither is there.
    """
    try:
        return by_steps(vehicle)
    except NotApplicable:
        if not vehicle.azimuths or missing(SOLVER):
            raise
        return SolverExact(vehicle)


class SolverExact:
    """Least effort for a wrench by a QP solver, held to EXACT_TOLERANCE."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Prepare the solver; raises NotApplicable where it refuses the vehicle."""
        self._solver, self.G = live(HARD, SOLVER, vehicle, None, None), generalized_inverse(vehicle)
        self.tolerance, self.closed_form = self._solver.tolerance, self.G.dot
        self._per_axis = 1.0 / vehicle.wrench_scale
        self._T = vehicle.TP * self._per_axis[:, None]

    def solve(self, wrench: FloatArray, limits: list[tuple[float, float]]) -> Allocation:
        """Allocate one wrench (k,) within the vehicle's own limits."""
        found = self._solver(wrench)
        if found.status is Status.SOLVED and not self._miss(found.f, wrench) <= EXACT_TOLERANCE:
            return found._replace(status=Status.NOT_CONVERGED)
        return found

    def solve_many(
        self, wrenches: FloatArray, lows: FloatArray, highs: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """``solve`` for wrenches (N, k): F (N, n) [N], and 0 where thrusts are found, else 2 (N,)."""
        found = [self.solve(wrench, []) for wrench in wrenches]
        excess = np.array([0.0 if one.status is Status.SOLVED else 2.0 for one in found])
        return np.array([one.f for one in found]).reshape(len(wrenches), len(self.G)), excess

    def _miss(self, f: FloatArray, wrench: FloatArray) -> float:
        return float(np.abs(self._T.dot(f) - wrench * self._per_axis).max())
