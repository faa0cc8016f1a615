"""Cascaded generalized inverse: freeze what saturates at its limit, solve the rest again, until none does."""

from functools import partial
from itertools import product

import numpy as np

from alloc.allocation import EXACT_TOLERANCE, FloatArray
from alloc.closed_forms.inverse import inverse_over
from alloc.closed_forms.saturating import Bounds, PolygonSaturating, Saturating
from alloc.errors import NotApplicable
from alloc.kernels import cascade, rules
from alloc.kernels.tolerance import TOLERANCE
from alloc.program import Program, Scalar, Where
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import nearest_thrusts
from alloc.vehicle.degeneracy import NOTHING

FORMULATION = "redistribute"
AZIMUTHS = True
MEANINGS = rules.MEANINGS

TABLE_THRUSTERS = 8
"""Up to this many working thrusters ``build`` makes the inverses of all patterns of frozen thrusters (256).
For more thrusters an inverse is made at its first use, so that a first call may cost tens of later ones."""

BEYOND = EXACT_TOLERANCE / 10
"""A thrust freezes where it is beyond a limit by more than this share of the largest one [-]. Rounding puts a
stuck thruster (f_min = f_max) just inside its limit or just beyond, which must not decide what others do; a
hundred thrusters that are cut by this miss no more of a wrench than SOLVED may."""
SPARE: dict[Scalar, float] = {"double": BEYOND, "float": TOLERANCE["float"]}
"""The same in C of either scalar: float rounds more."""
MOST_THRUSTERS = 62
"""Patterns of frozen thrusters are bits of signed 64-bit integers."""


class Cascade:
    """The passes: frozen thrusters stay at their limits, the others share what is left of the wrench."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Prepare the inverses of all patterns, up to TABLE_THRUSTERS."""
        self._vehicle = vehicle
        self._spare = BEYOND * vehicle.f_scale
        self._bits = 1 << np.arange(vehicle.n)
        self._working = int(self._bits[vehicle.working].sum())
        self._inverses: dict[int, FloatArray] = {}
        if len(vehicle.working) <= TABLE_THRUSTERS:
            for chosen in product([0, 1], repeat=len(vehicle.working)):
                self._inverse(int(np.dot(chosen, self._bits[vehicle.working])))

    def _inverse(self, free: int) -> FloatArray:
        """(n, k) generalized inverse over the thrusters whose bits are set in ``free``."""
        inverse = self._inverses.get(free)
        if inverse is None:
            inverse = inverse_over(self._vehicle, np.flatnonzero(free & self._bits))
            self._inverses[free] = inverse
        return inverse

    def mend(self, tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        """Thrusts for one wrench (k,), from f = T* tau as a list, and the passes taken."""
        TP, passes, spare = self._vehicle.TP, 0, self._spare
        free = self._working
        frozen = np.zeros(len(f))
        while free:
            before = free
            for i, (x, (low, high)) in enumerate(zip(f, limits.pairs, strict=True)):
                if not low - spare <= x <= high + spare and free >> i & 1:
                    frozen[i] = low if x < low else high
                    free ^= 1 << i
            if free == before:
                break
            f = (frozen + self._inverse(free).dot(tau - TP.dot(frozen))).tolist()
            passes += 1
        return f, passes

    def mend_polygons(self, tau: FloatArray, f: FloatArray) -> tuple[FloatArray, int]:
        """As ``mend`` where thrusters turn: one is frozen with both components, at its polygon's nearest."""
        v, free, frozen, passes = self._vehicle, self._working, np.zeros(len(f)), 0
        while free:
            near = nearest_thrusts(v.turning, f[None], v.f_min, v.f_max)[0]
            beyond = np.abs(f - near) > self._spare
            parts = [part for part in map(list, v.actuators) if beyond[part].any() and free >> part[0] & 1]
            if not parts:
                break
            for part in parts:
                frozen[part] = near[part]
                free &= ~int(self._bits[part].sum())
            f = frozen + self._inverse(free).dot(tau - v.TP.dot(frozen))
            passes += 1
        return f, passes

    def mend_many(self, taus: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Thrusts for wrenches (N, k), from F = T* tau (N, n); demands of one pattern go together.

        NaN where rounding decides whether a thrust freezes.
        """
        v = self._vehicle
        free = np.tile(v.readiness > 0, (len(taus), 1))
        F = F.copy()
        open_ = np.ones(len(taus), dtype=bool)
        spare, doubt = self._spare, NOTHING * v.f_scale
        while True:
            clipped = F.clip(low, high)
            excess = np.abs(F - clipped)
            F[open_ & (free & (np.abs(excess - spare) <= doubt)).any(axis=1)] = np.nan
            beyond = free & (excess > spare) & ~np.isnan(F)
            open_ = beyond.any(axis=1)
            rows = np.flatnonzero(open_)
            if not rows.size:
                return F
            free &= ~beyond
            F[rows] = np.where(free[rows], 0.0, clipped[rows])
            missing = taus[rows] - F[rows] @ v.TP.T
            patterns, which = np.unique(free[rows] @ self._bits, return_inverse=True)
            for i, pattern in enumerate(patterns):
                members = which == i
                F[rows[members]] += missing[members] @ self._inverse(int(pattern)).T


def build(vehicle: Vehicle) -> Saturating:
    """Prepare the cascade (Bordignon & Durham 1995, J. Guidance, Control, Dyn. 18(5); QCAT's cgi_alloc).

    Each pass freezes at least one thruster, so there are at most n. A frozen thruster is never freed,
    which is why the cascade may miss a wrench that could be met.
    """
    if vehicle.n > MOST_THRUSTERS:
        raise NotApplicable(
            f"redistribute covers up to {MOST_THRUSTERS} thrusters; {vehicle.name} has {vehicle.n}"
        )
    passes = Cascade(vehicle)
    if vehicle.azimuths:
        return PolygonSaturating(vehicle, FORMULATION, passes.mend_polygons)
    return Saturating(vehicle, FORMULATION, passes.mend, passes.mend_many)


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same with factors made in the call; raises NotApplicable where that loses too many digits."""
    _check_digits(vehicle, scalar)
    return rules.apply_rule(partial(cascade.freeze_thrusts, SPARE[scalar]), vehicle, limits, scalar)


def program_for_all(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """One program for the vehicle and many faults: those that leave as many digits."""
    _check_digits(vehicle, scalar)
    known = {
        fault: state
        for fault, state in rules.shared_states(vehicle, scalar).items()
        if doubt(state, scalar) <= cascade.DOUBT[scalar]
    }
    return rules.apply_rule(partial(cascade.freeze_thrusts, SPARE[scalar]), vehicle, limits, scalar, known)


def _check_digits(vehicle: Vehicle, scalar: Scalar) -> None:
    """Raise NotApplicable where factors made in the call lose too many digits."""
    if not (lost := doubt(vehicle, scalar)) <= cascade.DOUBT[scalar]:
        finer = "generate it in double, or " if scalar == "float" else ""
        raise NotApplicable(
            f"{vehicle.name}: redistribute downdates T* in the call, and in {scalar} that may cost"
            f" {lost:.1g} of the largest limit; {finer}take nullspace, scaled or clip"
        )


def doubt(vehicle: Vehicle, scalar: Scalar) -> float:
    """Share of the largest limit by which rounding may move a thrust in C [-]."""
    return cascade.doubt(vehicle, scalar)
