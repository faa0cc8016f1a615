"""Rules of practice that keep the current of all thrusters below a cap, behind thrusts of least effort."""

from collections.abc import Callable

import numpy as np

from alloc.allocation import Allocation, FloatArray, Status
from alloc.formulations.cap_rule import FORMULATION
from alloc.formulations.scaled import FORMULATION as SCALED
from alloc.nullspace.by_level import ByLevel, Mixed, allocator
from alloc.nullspace.current_cap import Capped, below_rest
from alloc.reach.edge import start
from alloc.vehicle import Vehicle
from alloc.vehicle.current import Draw
from alloc.vehicle.limits import Interval

Scaled = ByLevel | Mixed
CapRule = Callable[[Scaled, FloatArray, Interval, Draw, float], Allocation]
"""(scaled without a cap, tau, limits, currents, cap [A]) -> thrusts within the limits, meant for the cap."""


class CapRuled(Capped):
    """The allocator of a rule; without a cap, that of ``scaled``.

    INFEASIBLE says that rest draws more than the cap, NOT_CONVERGED that the rule's thrusts do.
    """

    def __init__(self, vehicle: Vehicle, rule: CapRule) -> None:
        """Prepare ``scaled``, which the rule stands behind or before."""
        super().__init__(vehicle, allocator(vehicle, SCALED))
        self.formulation, self._rule = FORMULATION.name, rule

    def allocate_under_cap(self, wrench: FloatArray, limits: Interval, draw: Draw, cap: float) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits (n,) [N] and a cap [A]."""
        if np.less_equal(*limits).all() and not draw.amps(start(*limits)).sum() <= cap:
            return below_rest(self._vehicle)
        found = self._rule(self._uncapped, wrench, limits, draw, cap)
        if not found.found:
            return found
        amps = draw.amps(found.f)
        if not amps.sum() <= cap:
            nothing = np.full(self._vehicle.n, np.nan)
            return Allocation(nothing, Status.NOT_CONVERGED, share=(0.0,), residual=np.zeros(self._vehicle.k))
        return found._replace(amps=amps)
