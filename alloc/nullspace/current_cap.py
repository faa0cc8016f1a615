"""Least effort along the demand, as far as the limits and a cap on the current allow."""

from collections.abc import Callable
from math import nan

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import Allocation, FloatArray, Status, StatusArray, checked
from alloc.nullspace.by_level import ByLevel, Mixed
from alloc.reach.edge import start
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, one_by_one
from alloc.vehicle.current import Draw, checked_cap

SPARE = 1e-9
"""Share of a cap by which a sum of currents may exceed it because of rounding [-]."""
STEPS = 64
"""Most thrusts computed on a path. Every second step halves what is left of it, so 64 leave 2e-10."""


class CurrentCap:
    """The allocator of a formulation with one level, whose calls may have a cap on the sum of currents.

    On the way of least effort to the demand, the share is the one at which the current reaches the cap.
    Currents are those of ``Vehicle.draw``. INFEASIBLE says, too, that thrusts at rest draw more than the cap.
    """

    limited = True

    def __init__(self, vehicle: Vehicle, uncapped: ByLevel | Mixed) -> None:
        """Wrap the allocator of calls without a cap."""
        self._vehicle, self._uncapped = vehicle, uncapped
        self.formulation, self.tolerance = uncapped.formulation, uncapped.tolerance
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
        found = self._uncapped(tau, f_min, f_max)
        if cap is None:
            return found
        most, draw = checked_cap(cap), self._vehicle.draw(volts)
        if not found.found:
            return found
        amps = draw.amps(found.f)
        if amps.sum() <= most:
            return found._replace(amps=amps)
        low, high = self._limits_of_call(f_min, f_max)
        rest = start(low, high)
        if not draw.amps(rest).sum() <= most:
            return below_rest(self._vehicle)
        wrench, begin = checked(tau, self._vehicle.k), self._vehicle.TP.dot(rest)

        def answers(share: float) -> Allocation:
            part = self._uncapped(begin + share * (wrench - begin), low, high)
            return part._replace(status=Status.PARTIAL, share=(share * part.share[0],))

        within, steps = cap_share(answers, draw, most, answers(0.0), found)
        return within._replace(iterations=found.iterations + steps, amps=draw.amps(within.f))

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
            return self._uncapped.many(taus, f_min, f_max)
        return one_by_one(self, self._vehicle, taus, f_min, f_max, cap=cap, volts=volts)


def below_rest(vehicle: Vehicle) -> Allocation:
    """Answer to a cap that is below what thrusts at rest draw: INFEASIBLE, thrusts (n,) NaN."""
    nothing = np.full(vehicle.n, nan)
    return Allocation(nothing, Status.INFEASIBLE, share=(0.0,), residual=np.zeros(vehicle.k))


def cap_share(
    answers: Callable[[float], Allocation], draw: Draw, cap: float, rest: Allocation, whole: Allocation
) -> tuple[Allocation, int]:
    """Answer on a path whose current reaches the cap from below, and the answers computed.

    Thrusts are linear in the share between the points where one of them meets a limit. So on the chord
    between two shares, one within the cap and one beyond, the current is convex, and where it reaches the cap
    is the answer if no limit is met between; else the chord gets shorter.

    Parameters
    ----------
    answers : function of a share that returns the answer for so much of the demand
    cap : on the sum of currents [A]
    rest, whole : the answers at the beginning of the path, within the cap, and at its end, beyond it
    """
    low, high, near = 0.0, whole.share[0], SPARE * cap
    within, beyond = rest, whole
    for step in range(STEPS):
        along = reaches(draw, cap - near / 2, within.f, beyond.f) if step % 2 == 0 else 0.5
        share = low + along * (high - low)
        if not low < share < high:
            break
        found = answers(share)
        over = float(draw.amps(found.f).sum()) - cap
        if over > 0.0:
            high, beyond = share, found
        else:
            low, within = share, found
        if -near <= over <= 0.0:
            break
    return within, step + 1


def reaches(draw: Draw, cap: float, f_low: FloatArray, f_high: FloatArray) -> float:
    """Part of the chord from thrusts within a cap [A] to others beyond where their current is the cap [-].

    Newton's steps from the far end of a convex function come nearer to its root and stay beyond it.
    """
    chord, t = f_high - f_low, 1.0
    for _ in range(STEPS):
        f = f_low + t * chord
        over = float(draw.amps(f).sum()) - cap
        rise = float(draw.rises(f).dot(chord))
        if over <= SPARE * cap / 4 or not rise > 0.0:
            break
        t -= over / rise
    return t
