"""Rules of practice that keep the current of all thrusters below a cap, behind thrusts of least effort."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import Allocation, FloatArray, Status, StatusArray, checked
from alloc.formulations.cap_rule import FORMULATION
from alloc.formulations.scaled import FORMULATION as SCALED
from alloc.nullspace.by_level import ByLevel, Mixed, allocator
from alloc.nullspace.current_cap import below_rest
from alloc.reach.edge import start
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, one_by_one
from alloc.vehicle.current import Draw, checked_cap
from alloc.vehicle.limits import Interval

Scaled = ByLevel | Mixed
CapRule = Callable[[Scaled, FloatArray, Interval, Draw, float], Allocation]
"""(scaled without a cap, tau, limits, currents, cap [A]) -> thrusts within the limits, meant for the cap."""


class CapRuled:
    """The allocator of a rule; without a cap, that of ``scaled``.

    INFEASIBLE says that rest draws more than the cap, NOT_CONVERGED that the rule's thrusts do.
    """

    formulation = FORMULATION.name
    limited = True

    def __init__(self, vehicle: Vehicle, rule: CapRule) -> None:
        """Prepare ``scaled``, which the rule stands behind or before."""
        self._vehicle, self._rule, self._scaled = vehicle, rule, allocator(vehicle, SCALED)
        self.tolerance = self._scaled.tolerance
        self._limits_of_call = at_call(vehicle, held=True)

    def __call__(
        self,
        tau: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits (n,) [N] and a cap [A], at a voltage [V]."""
        if cap is None:
            return self._scaled(tau, f_min, f_max)
        most, draw, wrench = checked_cap(cap), self._vehicle.draw(volts), checked(tau, self._vehicle.k)
        limits = self._limits_of_call(f_min, f_max)
        if np.less_equal(*limits).all() and not draw.amps(start(*limits)).sum() <= most:
            return below_rest(self._vehicle)
        found = self._rule(self._scaled, wrench, limits, draw, most)
        if not found.found:
            return found
        amps = draw.amps(found.f)
        if not amps.sum() <= most:
            nothing = np.full(self._vehicle.n, np.nan)
            return Allocation(nothing, Status.NOT_CONVERGED, share=(0.0,), residual=np.zeros(self._vehicle.k))
        return found._replace(amps=amps)

    def many(
        self,
        taus: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches within limits (n,) or (N, n) [N]; with a cap [A] one after the other."""
        if cap is None:
            return self._scaled.many(taus, f_min, f_max)
        return one_by_one(self, self._vehicle, taus, f_min, f_max, cap=cap, volts=volts)
