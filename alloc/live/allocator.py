"""An allocator around a prepared QP: it poses a demand, asks the solver, and judges the answer."""

from operator import le
from threading import Lock

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    WRENCH_TOLERANCE,
    Allocation,
    FloatArray,
    Status,
    StatusArray,
    Uncapped,
    answer,
    checked,
)
from alloc.errors import NotApplicable
from alloc.formulations import Formulation
from alloc.qp import Posed
from alloc.qp.certificate import Stationarity
from alloc.reach.attainable import beyond
from alloc.solvers import (
    MOVED,
    Level,
    Solve,
    Start,
    default_level,
    default_start,
    disbelieved,
    is_erratic,
    load,
    refuse_interface,
    shared,
)
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import SPARE, fit_polygons
from alloc.vehicle.call_limits import at_call, one_by_one
from alloc.vehicle.condition import magnified, promised

PARTIAL_TOLERANCE = 1e-2
"""Largest miss of a PARTIAL answer, relative to ``vehicle.wrench_scale`` [-]. The loosest of the solvers'
defaults stops at residuals near 1e-3; an answer ten times further off does not answer the demand."""
UNREACHABLE = 1e-9
"""Smallest part of a demand along directions that no thruster pushes that counts [-]; rounding is 1e-15."""


class Live(Uncapped):
    """The allocator; ``pose`` and ``solve`` are its two stages (``alloc.plugin.TwoStage``).

    Attributes
    ----------
    formulation : ``hard`` or ``soft``
    solve : function (b, lb, ub) -> Answer that is the binding's call and nothing else
    tolerance : promised distance to the optimum where SOLVED, relative to the largest limit [-]
    """

    limited = True

    def __init__(
        self,
        formulation: str,
        vehicle: Vehicle,
        posed: Posed,
        solve: Solve,
        tolerance: float,
        solver: str,
        erratic: bool = False,
    ) -> None:
        """Keep what every call needs: limits [N], T P and wrench in units of ``wrench_scale``."""
        self.formulation = formulation
        soft = len(posed.qp.g) > len(posed.working)
        # A soft answer is held to the promise in the call itself, whatever the vehicle.
        self.tolerance = promised(vehicle, tolerance if soft else tolerance * magnified(vehicle))
        self.solve = solve
        # A binding's object holds one problem; without the GIL two calls would mix theirs.
        self._alone = Lock()
        self._solver = solver
        self._erratic = erratic
        self._b_of_tau = posed.b_of_tau
        self._unreachable = posed.unreachable
        self._unit = posed.unit
        self._vehicle = vehicle
        self._limits_of_call = at_call(vehicle)
        self._working = posed.working
        self._m = len(posed.working)
        self._soft = Stationarity(posed.qp, posed.unit) if soft else None
        self._beyond = beyond(vehicle) if self._soft is None else None
        self._limits = vehicle.f_min[posed.working], vehicle.f_max[posed.working]
        self._turning = vehicle.turning
        self._lb, self._ub = posed.qp.lb[: self._m], posed.qp.ub[: self._m]
        self._per_axis = 1.0 / vehicle.wrench_scale
        self._T = vehicle.TP[:, posed.working] * self._per_axis[:, None]

    def pose(
        self, tau: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """b (p,), lb and ub (m,) of the QP for a wrench (k,) [N, N m] and limits (n,) [N], m working."""
        if f_min is None or f_max is None:
            return self._b_of_tau.dot(tau), self._lb, self._ub
        return self._posed(tau, f_min[self._working], f_max[self._working])

    def _posed(
        self, tau: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """As ``pose``, with limits (m,) of what works [N]."""
        return self._b_of_tau.dot(tau), low / self._unit, high / self._unit

    def allocate(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m], and judge the answer by equations.

        The solver's x is clipped to the limits; then, with the miss |T P f - tau| relative to
        ``wrench_scale``: SOLVED up to 1e-6; PARTIAL, with f as it is, up to 1e-2 (in the soft
        formulation: up to 1e-2 beyond the slack); NOT_CONVERGED beyond. So no f is SOLVED for a
        demand further than 1e-6 outside the attainable set. Soft thrusts are NOT_CONVERGED too where
        they are not shown to lie within ``tolerance`` of the optimum. INFEASIBLE are a demand along a
        direction that no thruster pushes, limits that contradict themselves, and what the solver calls
        infeasible if that is proven (``alloc.reach.attainable``); where it is not, NOT_CONVERGED. Of a
        solver whose refusals are ERRATIC, no matter which it gives, the proof alone is asked.
        """
        wrench = checked(tau, self._vehicle.k)
        low, high = self._limits
        if f_min is None and f_max is None:
            posed = self.pose(wrench)
        else:
            low, high = self._limits_of_call(f_min, f_max)
            if self._m < self._vehicle.n:
                low, high = low[self._working], high[self._working]
            if not all(map(le, low.tolist(), high.tolist())):
                return self._unanswered(Status.INFEASIBLE)
            posed = self._posed(wrench, low, high)
        if len(self._unreachable) and np.abs(self._unreachable.dot(wrench)).max() > UNREACHABLE:
            return self._unanswered(Status.INFEASIBLE)
        try:
            with self._alone:
                x, status, iterations, solver_s = self.solve(*posed)
        except MOVED as error:
            refuse_interface(self._solver, error)
        except RuntimeError as error:  # a binding's word for what it can't do must not end a control loop
            disbelieved[f"{self._solver}: RuntimeError: {str(error)[:60]}"] += 1
            return self._unanswered(Status.NOT_CONVERGED)
        if status != Status.SOLVED:
            claimed = status is Status.INFEASIBLE
            proven = (claimed or self._erratic) and self._infeasible(wrench, f_min, f_max)
            if claimed and not proven:
                disbelieved[f"{self._solver}: INFEASIBLE, which is not so"] += 1
            status = Status.INFEASIBLE if proven else Status.NOT_CONVERGED
            return self._unanswered(status, iterations, solver_s)
        f = x[: self._m] * self._unit
        np.minimum(f, high, out=f)
        np.maximum(f, low, out=f)
        if self._turning:
            whole = fit_polygons(self._turning, self._scattered(f)[None], SPARE * self._vehicle.f_scale)
            f = whole[0, self._working]
        if self._soft is not None and not self._optimal(f, *posed):
            return self._unanswered(Status.NOT_CONVERGED, iterations, solver_s)
        miss = self._T.dot(f) - self._per_axis * wrench
        # The Euclidean norm is never below the largest entry; its square is one product, and NaN fails it.
        if not (solved := miss.dot(miss) <= WRENCH_TOLERANCE**2):
            if self._soft is not None:
                miss -= x[self._m :]
            if not miss.dot(miss) <= PARTIAL_TOLERANCE**2:
                return self._unanswered(Status.NOT_CONVERGED, iterations, solver_s)
        if self._m < self._vehicle.n:
            f = self._scattered(f)
        return answer(f, Status.SOLVED if solved else Status.PARTIAL, iterations, solver_s)

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches, each in turn: a warm start sees them in order."""
        return one_by_one(self, self._vehicle, taus, f_min, f_max)

    def _infeasible(self, wrench: FloatArray, f_min: ArrayLike | None, f_max: ArrayLike | None) -> bool:
        if self._beyond is None:  # every demand has a soft answer
            return False
        return self._beyond(wrench, *self._limits_of_call(f_min, f_max))

    def _optimal(self, f: FloatArray, b: FloatArray, lb: FloatArray, ub: FloatArray) -> bool:
        assert self._soft is not None
        return self._soft.distance(f / self._unit, b, lb, ub) <= self.tolerance

    def _scattered(self, f_working: FloatArray) -> FloatArray:
        f = np.zeros(self._vehicle.n)
        f[self._working] = f_working
        return f

    def _unanswered(self, status: Status, iterations: int = 0, solver_s: float = np.nan) -> Allocation:
        return answer(np.full(self._vehicle.n, np.nan), status, iterations, solver_s)


def live(
    formulation: Formulation, name: str, vehicle: Vehicle, start: Start | None, level: Level | None
) -> Live:
    """Prepare the solver of that name for a formulation that is a QP; None takes the solver's default.

    Raises NotApplicable where the formulation is no QP, SolverError where the binding's interface has moved.
    """
    if formulation.pose is None:
        raise NotApplicable(f"{formulation.name}: is no quadratic program; a solver can't answer it")
    posed, solver = formulation.pose(vehicle, shared=shared(name)), load(name)
    level = level or default_level(solver)
    try:
        solve = solver.prepare(posed.qp, start or default_start(solver), level)
    except MOVED as error:
        refuse_interface(name, error)
    return Live(
        formulation=formulation.name,
        vehicle=vehicle,
        posed=posed,
        solve=solve,
        tolerance=solver.TOLERANCE[formulation.name][level],
        solver=name,
        erratic=is_erratic(name),
    )
