"""Exact allocator f = G tau + N z with the shortest z within the limits (eq. 4-5), or a refusal."""

from math import inf, nan
from operator import mul

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    EXACT_TOLERANCE,
    WRENCH_TOLERANCE,
    Allocation,
    FloatArray,
    Status,
    StatusArray,
    Uncapped,
    answer,
    checked,
    checked_many,
    no_cap,
)
from alloc.errors import NotApplicable
from alloc.formulations.hard import FORMULATION as HARD
from alloc.nullspace.region import nearest_many, prepare, steps_bound
from alloc.nullspace.slabs import polygon_slabs, whole_basis
from alloc.nullspace.structure import Structure, decompose
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import SPARE, fit_polygons
from alloc.vehicle.call_limits import at_call, limits_of
from alloc.vehicle.condition import condition, excess_that_misses, promised, wrench_doubt

TOLERANCE = 1e-9
"""Excess over a limit that still counts as met, relative to the largest limit [-]: far below anything a
thruster resolves, and above rounding unless T nearly loses rank, where it is what rounding leaves
(``alloc.vehicle.condition``). A demand outside the attainable set by less may be SOLVED: its thrusts are
moved onto the limits, and the wrench errs by EXACT_TOLERANCE at most."""

NEAR_EDGE = (1e-3, 1e3)
"""Excesses over a limit, in units of the one that counts as met, within which rounding might decide a
verdict: ``many`` then takes the verdict of a single call."""

WIDER = (1e-12, 1e-11, 1e-10, 1e-9, 1e-8)
"""By how much limits are moved apart, in turn, where a wrench was missed, relative to the largest [-]."""


class Nullspace(Uncapped):
    """The allocator; ``Allocation.iterations`` counts the elementary steps of a call.

    Attributes
    ----------
    worst_case_steps : steps that no demand can exceed, but for those taken again where rounding led astray
    """

    formulation = HARD.name
    limited = True

    def __init__(self, vehicle: Vehicle, structure: Structure, tolerance: float) -> None:
        """Precompute all that depends on the vehicle."""
        self.tolerance = promised(vehicle, TOLERANCE)
        self.G = structure.G
        self._k, self._n = vehicle.k, vehicle.n
        self._unreachable = structure.unreachable if len(structure.unreachable) else None
        self._vehicle = vehicle
        self._limits_of_call = at_call(vehicle)
        # Rounding of G is magnified where T nearly loses rank, and then a second product pays.
        self._rounds = wrench_doubt(vehicle) > EXACT_TOLERANCE / 10
        self.closed_form = self._refined if self._rounds else self.G.dot
        self._slack = tolerance * vehicle.f_scale
        # A demand may ask for what no thruster pushes, too: most of what may be missed is left for that.
        moving = EXACT_TOLERANCE if self._unreachable is None else EXACT_TOLERANCE / 100
        self._lost = EXACT_TOLERANCE - moving
        if tolerance < inf and not self._rounds:
            self._slack = min(self._slack, excess_that_misses(vehicle, EXACT_TOLERANCE))
        self._A = vehicle.TP / vehicle.wrench_scale[:, None]
        # No entry of T exceeds the length of its row: moving thrusts by this in all misses no more.
        self._held = moving * vehicle.f_scale
        self._limits = list(zip(vehicle.f_min.tolist(), vehicle.f_max.tolist(), strict=True))
        self._fixed = structure.fixed.tolist()
        self._blocks = [
            (block.rows.tolist(), block.N.tolist(), prepare(block.N, self._slack))
            for block in structure.blocks
        ]
        self.worst_case_steps = vehicle.n + sum(region.worst_case_steps for _, _, region in self._blocks)

    def __call__(
        self,
        tau: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits, which stand in right-hand sides only."""
        if cap is not None:
            raise no_cap(self.formulation)
        wrench = checked(tau, self._k)
        limits = self._limits
        if f_min is not None or f_max is not None:
            lows, highs = self._limits_of_call(f_min, f_max)
            limits = list(zip(lows.tolist(), highs.tolist(), strict=True))
            for low, high in limits:
                if low > high:
                    return self._infeasible(0)
        if self._unreachable is not None and np.abs(self._unreachable.dot(wrench)).max() > self._lost:
            return self._infeasible(0)
        found = self.solve(wrench, limits)
        if found.status is not Status.SOLVED:
            return answer(np.full(self._n, nan), found.status, found.iterations)
        return found

    def solve(self, wrench: FloatArray, limits: list[tuple[float, float]]) -> Allocation:
        """Allocate one wrench (k,) that the thrusters can push, inside pairs of f_min <= f_max [N].

        T (G tau + N z) is tau whatever z is, so thrusts miss the wrench by what they are moved onto limits.
        Where that is more than EXACT_TOLERANCE the status is not SOLVED.
        """
        f = self.closed_form(wrench)
        thrusts = f.tolist()
        for x, (low, high) in zip(thrusts, limits, strict=True):
            if not low <= x <= high:
                break
        else:
            return answer(f, Status.SOLVED, self._n)
        taken = self._moved(thrusts, limits)
        if taken is None:
            return self._infeasible(self._n)
        if _onto(limits, thrusts) > self._held:
            return self._again(wrench, limits, self._n + taken)
        return answer(np.array(thrusts), Status.SOLVED, self._n + taken)

    def _refined(self, wrench: FloatArray) -> FloatArray:
        """G tau, with what rounding of G takes of tau given back."""
        x: FloatArray = self.G.dot(2.0 * wrench - self._vehicle.TP.dot(self.G.dot(wrench)))
        return x

    def _moved(self, thrusts: list[float], limits: list[tuple[float, float]]) -> int | None:
        """Move thrusts to the least effort that makes the same wrench inside limits; None where none does.

        Returns the steps taken.
        """
        steps = 0
        for i in self._fixed:
            low, high = limits[i]
            if not low - self._slack <= thrusts[i] <= high + self._slack:
                return None
        for rows, N, region in self._blocks:
            z, taken = region.nearest(
                [limits[i][0] - thrusts[i] for i in rows], [limits[i][1] - thrusts[i] for i in rows]
            )
            steps += taken
            if z is None:
                return None
            for i, row in zip(rows, N, strict=True):
                thrusts[i] += sum(map(mul, row, z))
        return steps

    def _again(self, wrench: FloatArray, limits: list[tuple[float, float]], steps: int) -> Allocation:
        """``solve`` where the steps went wrong by more than rounding: the same within wider limits.

        A wrench on the edge leaves thrusts no room, so a step onto a thin row may go anywhere. Limits moved
        apart by more than rounding leave some; thrusts are moved back from those, and what the wrench then
        misses is shared by the thrusters that are free.
        """
        T = self._vehicle.TP
        x = self._refined(wrench)
        best, least = x, inf
        for wider in WIDER:
            by = wider * self._vehicle.f_scale
            thrusts: list[float] = x.tolist()
            if self._moved(thrusts, [(low - by, high + by) for low, high in limits]) is None:
                continue
            for _ in range(self._n):
                _onto(limits, thrusts)
                f = np.array(thrusts)
                rest = (wrench - T.dot(f)) / self._vehicle.wrench_scale
                missed = float(np.abs(rest).max())
                if missed < least:
                    best, least = f, missed
                free = [i for i, (low, high) in enumerate(limits) if low < thrusts[i] < high]
                if missed <= EXACT_TOLERANCE / 100 or not free:
                    break
                share = np.linalg.lstsq(self._A[:, free], rest, rcond=1e-7)[0]
                for i, more in zip(free, share.tolist(), strict=True):
                    thrusts[i] += more
            if least <= EXACT_TOLERANCE / 100:
                break
        # Thrusts this near that do not make the wrench stand at the edge of what can be made.
        missed_by = Status.INFEASIBLE if least <= WRENCH_TOLERANCE else Status.NOT_CONVERGED
        return answer(best, Status.SOLVED if least <= EXACT_TOLERANCE else missed_by, steps)

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches, all demands side by side; a verdict is always that of a single call."""
        wrenches = checked_many(taus, self._k)
        lows, highs = limits_of(self._vehicle, len(wrenches), f_min, f_max)
        F, excess = self.solve_many(wrenches, lows, highs)
        if self._unreachable is not None:
            excess = np.maximum(excess, np.abs(self._unreachable @ wrenches.T).max(axis=0) / self._lost)
        excess[(lows > highs).any(axis=1)] = inf
        status = np.where(excess <= 1.0, Status.SOLVED, Status.INFEASIBLE).astype(np.int8)
        F[excess > 1.0] = np.nan
        least, most = (0.0, inf) if self._rounds else NEAR_EDGE
        for i in np.flatnonzero((excess > least) & (excess < most)):
            F[i], status[i], *_ = self(wrenches[i], lows[i], highs[i])
        return F, status

    def solve_many(
        self, wrenches: FloatArray, lows: FloatArray, highs: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """``solve`` for wrenches (N, k) and limits (N, n): F (N, n) [N], and the excess over limits (N,).

        The excess is in units of what counts as met: up to 1 a wrench is attainable. Wrenches that are missed
        by more than rounding are allocated one by one; those that are missed again have an excess above 1, so
        small that a single call gives the verdict.
        """
        f = self.G @ wrenches.T
        if self._rounds:
            f += self.G @ (wrenches.T - self._vehicle.TP @ f)
        lower, upper = lows.T - f, highs.T - f
        fixed = np.maximum(lower[self._fixed], -upper[self._fixed])
        excess = fixed.max(axis=0, initial=0.0) / self._slack
        for rows, N, region in self._blocks:
            z, beyond = nearest_many(region, lower[rows], upper[rows])
            f[rows] += np.asarray(N) @ z
            excess = np.maximum(excess, beyond)
        F = f.T.clip(lows, highs)
        missed = np.abs(F - f.T).sum(axis=1) > self._held
        for i in np.flatnonzero(missed & (excess <= 1.0)):
            F[i], status, *_ = self.solve(
                wrenches[i], list(zip(lows[i].tolist(), highs[i].tolist(), strict=True))
            )
            excess[i] = excess[i] if status is Status.SOLVED else 2.0
        return F, excess

    def _infeasible(self, steps: int) -> Allocation:
        return answer(np.full(self._n, nan), Status.INFEASIBLE, steps)


def _onto(limits: list[tuple[float, float]], thrusts: list[float]) -> float:
    """Move thrusts beyond a limit onto it, and return by how much in all [N].

    Rounding leaves them there, or a demand outside the attainable set within TOLERANCE.
    """
    beyond = 0.0
    for i, (low, high) in enumerate(limits):
        x = thrusts[i]
        if not low <= x <= high:
            thrusts[i] = low if x < low else high
            beyond += abs(x - thrusts[i])
    return beyond


LARGEST_DOUBT = WRENCH_TOLERANCE / 4
"""Largest excess that may count as met [-]: thrusts off by it, n up to 16, still meet a wrench."""

STEPS_LIMIT = 5000
"""Largest worst case of a block, in steps. Up to here a call may take milliseconds in Python and setting up
a tenth of a second (measured on one x86-64 core, 3 x 11); an active-set solver needs neither."""


MOST_FREE = 3
"""Most dimensions of z in which steps are taken where thrusters turn."""


class PolygonNullspace(Nullspace):
    """The allocator; all of z is one block, whose rows are those of ``polygon_slabs``."""

    def __init__(self, vehicle: Vehicle, structure: Structure, tolerance: float) -> None:
        """Precompute all that depends on the vehicle; raises NotApplicable where steps would be too many."""
        d, n = vehicle.nullity, vehicle.n
        self._C, self._low, self._high = polygon_slabs(vehicle)
        if d > MOST_FREE or steps_bound(len(self._C), max(d, 1)) > STEPS_LIMIT:
            raise NotApplicable(
                f"nullspace: {len(vehicle.actuators)} thrusters, {len(vehicle.turning)} of them in polygons,"
                f" leave d = {d} and {len(self._C)} slabs; steps are taken up to d = {MOST_FREE} and in at"
                f" most {STEPS_LIMIT} steps, use a qp/ method"
            )
        super().__init__(vehicle, Structure(structure.G, (), np.arange(0), structure.unreachable), tolerance)
        self._N = whole_basis(structure, n)
        self._region = prepare(self._C @ self._N, self._slack) if d else None
        self.worst_case_steps = n + (self._region.worst_case_steps if self._region else 0)
        self._turning, self._own = vehicle.turning, (vehicle.f_min, vehicle.f_max)
        self._spare = SPARE * vehicle.f_scale

    def solve(self, wrench: FloatArray, limits: list[tuple[float, float]]) -> Allocation:
        """Allocate one wrench (k,) that the thrusters can push, inside the vehicle's own limits.

        The status is not SOLVED where thrusts that are moved into polygons miss more than EXACT_TOLERANCE.
        """
        f = self.closed_form(wrench)
        along = self._C.dot(f)
        steps = self._n
        if (along >= self._low).all() and (along <= self._high).all():
            return answer(f, Status.SOLVED, steps)
        best, least = f, np.inf
        for wider in (0.0, *WIDER):
            by = wider * self._vehicle.f_scale
            lower, upper = self._low - by - along, self._high + by - along
            if self._region is None:
                z, taken = np.zeros(0), 0
                if max(lower.max(), -upper.min()) > self._slack:
                    return self._infeasible(steps)
            else:
                found, taken = self._region.nearest(lower.tolist(), upper.tolist())
                if found is None:
                    return self._infeasible(steps + taken)
                z = np.array(found)
            steps += taken
            x = self._fit((f + self._N.dot(z))[None])[0]
            missed = float(self._miss(x, wrench))
            if missed < least:
                best, least = x, missed
            if least <= EXACT_TOLERANCE:
                return answer(best, Status.SOLVED, steps)
        # Thrusts this near that do not make the wrench stand at the edge of what can be made.
        return answer(best, Status.INFEASIBLE if least <= WRENCH_TOLERANCE else Status.NOT_CONVERGED, steps)

    def solve_many(
        self, wrenches: FloatArray, lows: FloatArray, highs: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """``solve`` for wrenches (N, k): F (N, n) [N], and the excess over limits (N,)."""
        f = self.G @ wrenches.T
        along = self._C @ f
        lower, upper = self._low[:, None] - along, self._high[:, None] - along
        if self._region is None:
            excess = np.maximum(lower, -upper).max(axis=0) / self._slack
        else:
            z, excess = nearest_many(self._region, lower, upper)
            f += self._N @ z
        F = self._fit(f.T)
        missed = np.array([self._miss(x, wrench) for x, wrench in zip(F, wrenches, strict=True)])
        for i in np.flatnonzero(~(missed <= EXACT_TOLERANCE) & (excess <= 1.0)):
            F[i], status, *_ = self.solve(wrenches[i], [])
            excess[i] = excess[i] if status is Status.SOLVED else 2.0
        return F, excess

    def _miss(self, f: FloatArray, wrench: FloatArray) -> float:
        """Largest |T P f - tau| of any axis, relative to ``wrench_scale`` [-]."""
        return float(np.abs((self._vehicle.TP.dot(f) - wrench) / self._vehicle.wrench_scale).max())

    def _fit(self, F: FloatArray) -> FloatArray:
        """Thrusts (N, n) that lie outside of their limits by rounding, moved inside."""
        low, high = self._own
        return fit_polygons(self._turning, np.minimum(np.maximum(F, low), high), self._spare)


def exact(vehicle: Vehicle, tolerance: float = TOLERANCE) -> Nullspace:
    """Prepare the exact answer.

    ``tolerance`` is the excess over a limit that still counts as met, relative to the largest limit [-], or
    what rounding leaves of it. Raises NotApplicable where that is too much for SOLVED to mean anything, and
    where a block may take more than STEPS_LIMIT steps; thrusters that turn are in one block.
    """
    if (doubt := wrench_doubt(vehicle)) > LARGEST_DOUBT:
        raise NotApplicable(
            f"{vehicle.name}: T nearly loses rank, condition {condition(vehicle):.2g}, so rounding alone "
            f"moves thrusts by {doubt:.1g} of the largest limit; leave out the weakest DOF, or use qp/daqp"
        )
    structure = decompose(vehicle)
    if vehicle.azimuths:
        return PolygonNullspace(vehicle, structure, max(tolerance, doubt))
    for block in structure.blocks:
        m, d = block.N.shape
        if (bound := steps_bound(m, d)) > STEPS_LIMIT:
            raise NotApplicable(
                f"nullspace: {m} thrusters share a {d}-dimensional null space, up to {bound} steps a call; "
                f"more than {STEPS_LIMIT} are refused, use a qp/ method"
            )
    return Nullspace(vehicle, structure, max(tolerance, doubt))
