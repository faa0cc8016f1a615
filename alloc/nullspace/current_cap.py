"""Least effort along the demand, as far as the limits and a cap on the current allow."""

from collections.abc import Callable
from functools import lru_cache
from math import nan

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import Allocation, FloatArray, Status, StatusArray, answer, checked
from alloc.nullspace.by_level import ByLevel, Mixed
from alloc.reach.edge import start
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, one_by_one
from alloc.vehicle.current import Draw, checked_cap
from alloc.vehicle.limits import Interval

SPARE = 1e-9
"""Share of a cap by which a sum of currents may exceed it because of rounding [-]."""
STEPS = 96
"""Most thrusts computed on a path. Every third step halves what is left of it, so 96 leave 2e-10."""


class Capped:
    """Base of allocators whose calls may have a cap on the sum of currents; else ``uncapped`` answers.

    Currents are those of ``Vehicle.draw``.
    """

    formulation: str
    limited = True

    def __init__(self, vehicle: Vehicle, uncapped: ByLevel | Mixed) -> None:
        """Wrap the allocator of calls without a cap."""
        self._vehicle, self._uncapped = vehicle, uncapped
        self.formulation, self.tolerance = uncapped.formulation, uncapped.tolerance
        self._limits_of_call = at_call(vehicle, held=True)
        self._draw = lru_cache(maxsize=256)(vehicle.draw)

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
            return self._uncapped(tau, f_min, f_max)
        most, draw = checked_cap(cap), self._draw(volts)
        wrench, limits = checked(tau, self._vehicle.k), self._limits_of_call(f_min, f_max)
        return self.allocate_under_cap(wrench, limits, draw, most)

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

    def allocate_under_cap(self, wrench: FloatArray, limits: Interval, draw: Draw, cap: float) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits (n,) [N] and a cap [A]."""
        raise NotImplementedError


class CurrentCap(Capped):
    """The allocator of a formulation whose calls may have a cap on the sum of currents.

    On the way of least effort to the demand, the share is the one at which the current reaches the cap; of
    several levels all stop there, but those that a limit stopped before. INFEASIBLE says, too, that thrusts
    at rest draw more than the cap.
    """

    def __init__(self, vehicle: Vehicle, uncapped: ByLevel | Mixed) -> None:
        """Wrap the allocator of calls without a cap."""
        super().__init__(vehicle, uncapped)
        self._rest, self._levels = np.zeros(vehicle.n), uncapped.levels
        self._straight = uncapped if isinstance(uncapped, ByLevel) and uncapped.goes_straight else None

    def allocate_under_cap(self, wrench: FloatArray, limits: Interval, draw: Draw, cap: float) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits (n,) [N] and a cap [A]."""
        low, high = limits
        within = self._before_limits(wrench, low, high, draw, cap)
        if within is not None and len(within.amps):
            return within if np.sum(within.amps) <= cap else below_rest(self._vehicle, self._levels)
        found = self._uncapped(wrench, low, high)
        if not found.found:
            return found
        amps = draw.amps(found.f)
        if amps.sum() <= cap:
            return found._replace(amps=amps)
        answers = self._answers(wrench, low, high, found)
        if within is None:
            within = answers(0.0)
            if not draw.amps(start(low, high)).sum() <= cap:
                return below_rest(self._vehicle, self._levels)
        within, steps = cap_share(answers, draw, cap, within, found)
        return within._replace(iterations=found.iterations + steps, amps=draw.amps(within.f))

    def _before_limits(
        self, wrench: FloatArray, low: FloatArray, high: FloatArray, draw: Draw, cap: float
    ) -> Allocation | None:
        """Answer at which the path meets a limit, or the cap [A] where that comes first, then with its amps.

        None where limits exclude 0, and where a level stops before any limit.
        """
        lows, highs = low.tolist(), high.tolist()
        if self._straight is None or not max(lows) <= 0.0 <= min(highs):
            return None
        f, residual = self._straight.unlimited(wrench)
        share = 1.0
        for x, least, most in zip(f.tolist(), lows, highs, strict=True):
            if not least <= share * x <= most:
                share = (least if x < 0.0 else most) / x
        f = (share * f).clip(low, high)
        part = reaches(draw, cap * (1 - SPARE / 2), self._rest, f)
        amps: FloatArray | tuple[()] = ()
        if part < 1.0:
            f, share = part * f, part * share
            amps = draw.amps(f)
        shares = self._levels * (share,)
        return answer(f, Status.PARTIAL, len(f), share=shares, residual=share * residual, amps=amps)

    def _answers(
        self, wrench: FloatArray, low: FloatArray, high: FloatArray, whole: Allocation
    ) -> Callable[[float], Allocation]:
        """A function of a share that returns the answer for so much of the demand."""
        rest = start(low, high)
        begin = self._vehicle.TP.dot(rest)
        path = None if self._straight is None else self._straight.path(wrench, low, high)

        def answers(share: float) -> Allocation:
            if (
                path is not None
                and (found := path(tuple(min(share, one) for one in whole.share))) is not None
            ):
                return found
            found = self._uncapped(begin + share * (wrench - begin), low, high)
            shares = tuple(share * one for one in found.share)
            return found._replace(status=Status.PARTIAL, share=shares)

        return answers


def below_rest(vehicle: Vehicle, levels: int = 1) -> Allocation:
    """Answer to a cap that is below what thrusts at rest draw: INFEASIBLE, thrusts (n,) NaN, shares 0."""
    nothing = np.full(vehicle.n, nan)
    return Allocation(nothing, Status.INFEASIBLE, share=(0.0,) * levels, residual=np.zeros(vehicle.k))


def cap_share(
    answers: Callable[[float], Allocation], draw: Draw, cap: float, within: Allocation, beyond: Allocation
) -> tuple[Allocation, int]:
    """Answer on a path whose current reaches the cap from below, and the answers computed.

    Thrusts are linear in the share between the points where one of them meets a limit. So on the chord
    between two shares, one within the cap and one beyond, the current is convex, and where it reaches the cap
    is the answer if no limit is met between; else the chord gets shorter.

    Parameters
    ----------
    answers : function of a share that returns the answer for so much of the demand
    cap : on the sum of currents [A]
    within, beyond : answers on the path within the cap and beyond; of several levels the largest share counts
    """
    low, high, near = max(within.share), max(beyond.share), SPARE * cap
    for step in range(STEPS):
        along = reaches(draw, cap - near / 2, within.f, beyond.f) if step % 3 < 2 else 0.5
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
    """Part 0 … 1 of the chord from thrusts within a cap [A] to others at which their current is the cap.

    It is 1 where the current at the other end is within the cap. Newton's steps stay beyond the root of a
    convex function once they are. They begin where it is if currents grow with the power 3/2 of thrusts.
    """
    begin, step, near = f_low.tolist(), (f_high - f_low).tolist(), SPARE * cap / 4
    most, _ = draw.total(begin, step, 1.0)
    if most <= cap:
        return 1.0
    least, _ = draw.total(begin, step, 0.0)
    if least >= cap:
        return 0.0
    t = float(((cap - least) / (most - least)) ** (2 / 3))
    for _ in range(STEPS):
        current, rise = draw.total(begin, step, t)
        if abs(current - cap) <= near:
            break
        t = min(max(t - (current - cap) / rise, 0.0), 1.0) if rise > 0.0 else 1.0
    return t
