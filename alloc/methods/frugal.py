"""The least current that makes the wrench, and the largest share under a cap: a linear program a call."""

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import EXACT_TOLERANCE, Allocation, FloatArray, Status, StatusArray
from alloc.formulations.frugal import FORMULATION as ANSWERED
from alloc.nullspace.by_level import ByLevel, Mixed, allocator
from alloc.nullspace.current_cap import SPARE, below_rest, reaches
from alloc.reach.edge import start
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, one_by_one
from alloc.vehicle.current import Draw, PowerLaw, checked_cap, make_draw

FORMULATION = ANSWERED.name
NAMED_ONLY = True  # 4 to 12 ms: a linear program in each call
UNKNOWN = PowerLaw(1.0, 1.0, 1.5)
"""Current of each thruster of a vehicle whose file says none: what is least is the same in any unit."""


def build(vehicle: Vehicle) -> "Frugal":
    """Prepare to go straight from rest towards the demand as far as it is attainable, at least current."""
    return Frugal(vehicle)


class Frugal:
    """The allocator; a cap is refused where the vehicle's file says no currents.

    Currents are those of ``Vehicle.draw``, a power law by its pieces, which lie on it and above. So no sum
    exceeds a cap, and where all currents are tables no other thrusts make a larger share.
    """

    limited = True

    def __init__(self, vehicle: Vehicle) -> None:
        """Prepare thrusts of least effort, from which each program starts."""
        uncapped = allocator(vehicle, ANSWERED)
        self._vehicle, self._mixed = vehicle, uncapped if isinstance(uncapped, Mixed) else None
        self._parts = uncapped.parts if isinstance(uncapped, Mixed) else [uncapped]
        self.formulation, self.tolerance = FORMULATION, uncapped.tolerance
        self._limits_of_call = at_call(vehicle, held=True)
        self._known = bool(vehicle.esc) and all(esc.current is not None for esc in vehicle.esc)

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
        most = np.inf if cap is None else checked_cap(cap)
        if self._known or cap is not None:
            draw = self._vehicle.draw(volts)
        else:
            draw = make_draw((UNKNOWN,) * self._vehicle.n, (0.0,) * self._vehicle.n)
        if self._mixed is None:
            return self._answer(self._parts[0], tau, f_min, f_max, draw, most)
        # Currents are convex in the thrusts, so a mixture of answers draws no more than they do.
        answers = [
            self._answer(part, tau, f_min, f_max, draw, most * (1 - SPARE / 2)) for part in self._parts
        ]
        found = self._mixed.mix(answers, f_min, f_max)
        return found._replace(amps=draw.amps(found.f)) if self._known and found.found else found

    def _answer(
        self,
        way: ByLevel,
        tau: ArrayLike,
        f_min: ArrayLike | None,
        f_max: ArrayLike | None,
        draw: Draw,
        most: float,
    ) -> Allocation:
        """The answer of one way, with a current of ``most`` [A] at the most."""
        found = way(tau, f_min, f_max)
        if not found.found:
            return found
        low, high = self._limits_of_call(f_min, f_max)
        rest = start(low, high)
        _, f = self._solved(way, draw, rest, found.f, low, high, None)
        if not draw.amps(f).sum() < draw.amps(found.f).sum():  # the program finds none better
            f = found.f
        if draw.amps(f).sum() <= most:
            return self._changed(way, found, rest, f, 1.0, draw)
        if not draw.amps(rest).sum() <= most:
            return below_rest(self._vehicle)
        part, f = self._largest(way, draw, rest, f, low, high, most)
        return self._changed(way, found._replace(status=Status.PARTIAL), rest, f, part, draw)

    def many(
        self,
        taus: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches one after the other, each within its own limits."""
        return one_by_one(self, self._vehicle, taus, f_min, f_max, cap=cap, volts=volts)

    def _changed(
        self, way: ByLevel, found: Allocation, rest: FloatArray, f: FloatArray, part: float, draw: Draw
    ) -> Allocation:
        """The answer with thrusts f (n,) that make a part of what ``found`` makes of the way from rest."""
        residual = np.asarray(found.residual)
        if way.strong is not self._vehicle:  # what f makes along weak directions is its own
            promised = self._vehicle.TP.dot(found.f) - residual
            begin = self._vehicle.TP.dot(rest)
            residual = self._vehicle.TP.dot(f) - (begin + part * (promised - begin))
        amps = draw.amps(f) if self._known else ()
        return found._replace(f=f, share=(part * found.share[0],), residual=residual, amps=amps)

    def _largest(
        self,
        way: ByLevel,
        draw: Draw,
        rest: FloatArray,
        f: FloatArray,
        low: FloatArray,
        high: FloatArray,
        cap: float,
    ) -> tuple[float, FloatArray]:
        """Largest part of the way from ``rest`` to f with a current within the cap [A], and thrusts (n,)."""
        part, best = self._solved(way, draw, rest, f, low, high, cap)
        # The wrench is linear in the thrusts, so where rounding exceeds the cap they are drawn back.
        if draw.amps(best).sum() > cap:
            back = reaches(draw, cap * (1 - SPARE / 2), rest, best)
            part, best = back * part, rest + back * (best - rest)
        return part, best

    def _solved(
        self,
        way: ByLevel,
        draw: Draw,
        rest: FloatArray,
        f: FloatArray,
        low: FloatArray,
        high: FloatArray,
        cap: float | None,
    ) -> tuple[float, FloatArray]:
        """The program min sum I, or max part with sum I <= cap: T P x = T P rest + part T P (f - rest).

        Its unknowns are how far each thrust x_i goes along each straight piece of its curve from f_min, and
        the part, 1 without a cap. Slopes rise, so no piece is taken before those that cost less. Returns part
        and x (n,), which make that wrench to rounding.
        """
        from scipy.optimize import linprog

        n, T = len(f), way.strong.TP / self._vehicle.wrench_scale[:, None]
        thruster, length, slope = draw.pieces(low, high)
        step = T.dot(f - rest)
        capped = cap is not None
        found = linprog(
            np.append(np.zeros_like(slope), -1.0) if capped else np.append(slope, 0.0),
            A_ub=np.append(slope, 0.0)[None] if capped else None,
            b_ub=[cap - draw.amps(low).sum()] if capped else None,
            A_eq=np.hstack([T[:, thruster], -step[:, None]]),
            b_eq=T.dot(rest - low),
            bounds=[*((0.0, far) for far in length.tolist()), (0.0 if capped else 1.0, 1.0)],
            method="highs",
            # HiGHS accepts no tighter tolerances.
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if found.x is None:
            return (0.0, rest) if capped else (1.0, f)
        part = float(found.x[-1])
        x = (low + np.bincount(thruster, found.x[:-1], n)).clip(low, high)
        wrench = T.dot(rest) + part * step
        free = (x > low) & (x < high)
        if free.any():
            x[free] += np.linalg.lstsq(T[:, free], wrench - T.dot(x), rcond=1e-9)[0]
            x = x.clip(low, high)
        if np.abs(wrench - T.dot(x)).max() > EXACT_TOLERANCE:
            return (0.0, rest) if capped else (1.0, f)
        return part, x
