"""Constrained allocation, eq. 4-5, by a live solver: set up once, only the demand changes.

What SOLVED means is decided here, by equations, whatever the solver says (``Live.__call__``).
"""

import numpy as np
from numpy.typing import ArrayLike

from alloc import solvers
from alloc.allocation import Allocation, FloatArray, Status, StatusArray, answer, checked, one_by_one
from alloc.qp import Posed, pose_hard
from alloc.solvers import Level, Solve, Start
from alloc.vehicle import Vehicle

FORMULATION = "hard"
LEVELS = solvers.LEVELS

WRENCH_TOLERANCE = 1e-6
"""Largest |T P f - tau| of a SOLVED answer, relative to ``vehicle.wrench_scale`` [-]. A thruster's
curve is known to a percent at best, so this is far below what a vehicle can notice, and still ten
times what the tight settings of an iterative solver leave."""
PARTIAL_TOLERANCE = 1e-2
"""The same of a PARTIAL answer [-]: the loosest default here stops at residuals near 1e-3; one that
is ten times off is no answer to this demand, whatever its solver calls it."""
UNREACHABLE = 1e-9
"""A demand's part along directions that no thruster pushes counts from here [-]; rounding is 1e-15."""


def variants() -> dict[str, str]:
    """``qp/<solver>`` for every file in ``alloc/solvers``; what is missing, where something is."""
    return {f"qp/{name}": solvers.missing(name) for name in solvers.names()}


def STARTS(name: str) -> tuple[Start, ...]:
    """What the solver's binding can do."""
    return _solver(name).STARTS


def SUMMARY(name: str) -> str:
    """One line for the catalogue."""
    return f"eq. 4-5 by {_solver(name).ALGORITHM}"


def build(name: str, vehicle: Vehicle, start: Start | None = None, level: Level = "default") -> "Live":
    """Prepare ``qp/<solver>``; ``start`` is ``reused`` unless given."""
    solver = _solver(name)
    posed = pose_hard(vehicle)
    solve = solver.prepare(posed.qp, start or solvers.default_start(solver), level)
    return Live(FORMULATION, vehicle, posed, solve, solver.TOLERANCE[level])


def _solver(name: str) -> solvers.Solver:
    return solvers.load(name.partition("/")[2])


class Live:
    """An allocator around a prepared QP; ``pose`` and ``solve`` are its two halves, to be timed apart.

    Attributes
    ----------
    solve : b -> Answer, the binding's call and nothing else
    tolerance : promised distance to the optimum where SOLVED, relative to the largest limit [-]
    """

    limited = True

    def __init__(
        self, formulation: str, vehicle: Vehicle, posed: Posed, solve: Solve, tolerance: float
    ) -> None:
        """Keep what every call needs: limits [N], T P and wrench in units of ``wrench_scale``."""
        self.formulation = formulation
        self.tolerance = tolerance
        self.solve = solve
        self._b_of_tau = posed.b_of_tau
        self._unreachable = posed.unreachable
        self._f_scale = posed.f_scale
        self._m = len(posed.working)
        # Most vehicles have every thruster working: a slice is a tenth of the price of an index.
        self._on = posed.working if self._m < vehicle.n else slice(None)
        self._f_min, self._f_max = vehicle.f_min[self._on], vehicle.f_max[self._on]
        self._shape = vehicle.k, vehicle.n
        self._per_axis = 1.0 / vehicle.wrench_scale
        self._T = vehicle.TP * self._per_axis[:, None]

    def pose(self, tau: FloatArray) -> FloatArray:
        """b (p,) of the QP for a wrench (k,) [N, N m]."""
        b: FloatArray = self._b_of_tau.dot(tau)
        return b

    def __call__(self, tau: ArrayLike) -> Allocation:
        """Allocate one wrench (k,) [N, N m], and judge the answer by equations.

        The solver's x is clipped to the limits; then, with the miss max |T P f - tau| relative to
        ``wrench_scale``: SOLVED up to 1e-6, PARTIAL (f as it is) up to 1e-2, else NOT_CONVERGED. So
        no f is ever SOLVED for a demand further than 1e-6 outside the attainable set. INFEASIBLE is
        the solver's word, or a demand along a direction that no thruster pushes.
        """
        wrench = checked(tau, self._shape[0])
        if len(self._unreachable) and np.abs(self._unreachable.dot(wrench)).max() > UNREACHABLE:
            return self._no_answer(Status.INFEASIBLE)
        x, status, iterations, solver_s = self.solve(self.pose(wrench))
        if status != Status.SOLVED:
            return self._no_answer(status, iterations, solver_s)
        thrusts = x[: self._m] * self._f_scale
        np.minimum(thrusts, self._f_max, out=thrusts)
        np.maximum(thrusts, self._f_min, out=thrusts)
        f = np.zeros(self._shape[1])
        f[self._on] = thrusts
        miss = np.abs(self._T.dot(f) - self._per_axis * wrench).max()
        if miss <= WRENCH_TOLERANCE:
            return answer(f, Status.SOLVED, iterations, solver_s)
        if miss <= PARTIAL_TOLERANCE:
            return answer(f, Status.PARTIAL, iterations, solver_s)
        return self._no_answer(Status.NOT_CONVERGED, iterations, solver_s)  # NaN ends here too

    def many(self, taus: ArrayLike) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches, each in turn: a warm start sees them in order."""
        return one_by_one(self, taus, *self._shape)

    def _no_answer(self, status: Status, iterations: int = 0, solver_s: float = np.nan) -> Allocation:
        return answer(np.full(self._shape[1], np.nan), status, iterations, solver_s)
