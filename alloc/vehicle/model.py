"""A vehicle as the allocators see it: T, H, limits and readiness, checked and frozen."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alloc.allocation import FloatArray, IndexArray
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.autopilot import Autopilot
from alloc.vehicle.azimuth import (
    Azimuth,
    HalfPlanes,
    actuators,
    bounding_box,
    check_azimuths,
    half_planes,
    refuse_azimuths,
)
from alloc.vehicle.checks import ARRAYS, check_parts, check_shapes, check_values, checked_array
from alloc.vehicle.current import Cap, Draw
from alloc.vehicle.degeneracy import RANK_TOLERANCE, independent
from alloc.vehicle.esc import Esc, Sent, esc_commands, esc_draw, esc_limits, esc_thrusts
from alloc.vehicle.frame import Frame, checked_frame, turned
from alloc.vehicle.geometry import DOF
from alloc.vehicle.limits import Interval, Slew, VoltageTable, of_a_moment
from alloc.vehicle.moment import sets_of_a_moment
from alloc.vehicle.names import Priority, check_names, checked_levels, checked_priority, thruster_index
from alloc.vehicle.weak import (
    ALL_WEAK,
    DRAWN,
    WEAK,
    Directions,
    Survey,
    check_limit,
    couplings,
    directions,
    doubts,
    omissions,
)


@dataclass(frozen=True, eq=False)
class Vehicle:
    """Thrusters, what they push, and what they can give: tau = T P f (eq. 2).

    Attributes
    ----------
    name : label in tables
    dof : controlled degrees of freedom, the rows of T, out of ``alloc.vehicle.geometry.DOF``
    T : (k, n) configuration matrix; force rows [-], moment rows [m]
    H : (n, n) symmetric positive definite weight of eq. 4 [1/N^2]
    f_min, f_max : (n,) limits of each thruster, 0 where it is off [N]
    readiness : (n,) diagonal of P: 1 ready, 0 off, between them weakened [-]
    slack_weights : (k,) diagonal of Q for the soft formulation
    source : where the numbers come from
    whole : name of the vehicle without its faults; empty for a vehicle without any
    slew : how fast thrusts may change, None where nothing says
    by_volts : limits by the battery's voltage, None where nothing says
    priority : axes in levels, those that are served first in front; given empty, one level with all axes
    groups : axes in groups that are scaled together; empty for those that share thrusters
    names : what people call each thruster, "" for one without a name; empty where none has one
    frame : of T and of every wrench: frd (x ahead, y to starboard, z down) or flu (x ahead, y to port, z up)
    esc : (n,) what stands between each thrust and the wire; empty where nothing says
    cap : on what all thrusters draw together, for calls to be given; None where nothing says
    inertia : (6,) mass or moment of inertia of each of ``DOF``, added one included [kg, kg m^2]; None where
        nothing says
    survey : how well the geometry is known
    weak_limit : sigma / sigma_max up to which a direction is weak; None where the survey decides
    autopilot : what mixes today, None where nothing says
    units : (k,) lengths that rows of T count with; None where these are their own
    poses : (6, n) all six rows that poses make, uncontrolled axes too; None where T is all that is known
    azimuths : thrusters that turn; of each, two components of f and all (n,) and (k, n) that goes with them
        are of forces along x and y, whose limits are those of the smallest box around its polygon
    """

    name: str
    dof: tuple[str, ...]
    T: FloatArray
    H: FloatArray
    f_min: FloatArray
    f_max: FloatArray
    readiness: FloatArray
    slack_weights: FloatArray
    source: str = ""
    whole: str = ""
    slew: Slew | None = None
    by_volts: VoltageTable | None = None
    priority: Priority = ()
    names: tuple[str, ...] = ()
    frame: Frame = "frd"
    esc: tuple[Esc, ...] = ()
    groups: Priority = ()
    survey: Survey = DRAWN
    weak_limit: float | None = None
    autopilot: Autopilot | None = None
    units: FloatArray | None = None
    poses: FloatArray | None = None
    cap: Cap | None = None
    inertia: FloatArray | None = None
    azimuths: tuple[Azimuth, ...] = ()

    def __post_init__(self) -> None:
        """Freeze private copies of the arrays; raise VehicleError where they describe no vehicle."""
        there = {
            key: value for key in (*ARRAYS, "poses", "inertia") if (value := getattr(self, key)) is not None
        }
        arrays = {key: checked_array(self.name, key, value) for key, value in there.items()}
        checked_frame(self.frame)
        check_shapes(self.name, self.dof, arrays)
        n = len(arrays["f_min"])
        check_names(self.names, len(actuators(self.azimuths, n)))
        object.__setattr__(self, "priority", checked_priority(self.priority, self.dof))
        object.__setattr__(self, "groups", checked_levels(self.groups, self.dof, "groups", "group"))
        if self.azimuths:
            others = (self.by_volts, self.autopilot, self.cap, *self.esc)
            check_azimuths(self.name, self.azimuths, arrays["readiness"], others)
            bounding_box(self.azimuths, arrays["f_min"], arrays["f_max"])
        for key in ("f_min", "f_max"):  # a thruster that is off gives 0, however the vehicle was made
            arrays[key] = np.where(arrays["readiness"] == 0, 0.0, arrays[key])
        check_values(self.name, self.names, arrays)
        for key, array in arrays.items():
            object.__setattr__(self, key, _frozen(array))
        if self.inertia is not None and (self.inertia.shape != (6,) or not (self.inertia > 0.0).all()):
            raise VehicleError(f"{self.name}: inertia: give mass and three moments above 0", "inertia")
        check_parts(self.name, n, self.slew, self.by_volts, self.esc)
        check_limit(self.name, self.weak_limit)

    @property
    def k(self) -> int:
        """Number of controlled degrees of freedom."""
        return len(self.T)

    @property
    def n(self) -> int:
        """Number of thrusters, those that are off included; one that turns counts twice, as it does in f."""
        return len(self.f_min)

    @cached_property
    def actuators(self) -> tuple[tuple[int, ...], ...]:
        """The components of f of each thruster: one, or two, along x and y, of one that turns."""
        return actuators(self.azimuths, self.n)

    @cached_property
    def turning(self) -> tuple[Azimuth, ...]:
        """The ``azimuths`` that are not off."""
        return tuple(one for one in self.azimuths if self.readiness[one.first])

    @property
    def ready(self) -> list[int]:
        """Indices of the thrusters that are not off; ``working`` are those of their thrusts."""
        return [i for i, (first, *_) in enumerate(self.actuators) if self.readiness[first]]

    @cached_property
    def half_planes(self) -> HalfPlanes | None:
        """Limits A f <= reach of thrusters that turn and work; None where there is none."""
        return half_planes(self.turning, self.n)

    def called(self, thruster: int) -> str:
        """A thruster in words: its name, or ``thruster 4`` where it has none."""
        return (self.names and self.names[thruster]) or f"thruster {thruster}"

    def index(self, thruster: int | str) -> int:
        """Index of a thruster given by index or by name; raises VehicleError where there is none such."""
        return thruster_index(thruster, self.names, len(self.actuators), self.name)

    @cached_property
    def working(self) -> IndexArray:
        """(m,) indices of the thrusters that are not off."""
        return _frozen(np.flatnonzero(self.readiness))

    @cached_property
    def TP(self) -> FloatArray:
        """(k, n) effective matrix T P of eq. 2."""
        return _frozen(self.T * self.readiness)

    @cached_property
    def rank(self) -> int:
        """Rank of T P: how many independent directions the working thrusters can push.

        It is 0 where they push nothing but rounding, as a lateral thruster does along surge.
        """
        sigma = np.linalg.svd(self.TP / self.row_lengths[:, None], compute_uv=False)
        return independent(sigma)

    @property
    def faults(self) -> tuple[tuple[int, float], ...]:
        """Each thruster that is not fully ready, with its readiness: 0 off, below 1 weakened [-]."""
        ready = self.readiness.tolist()
        return tuple((i, ready[j]) for i, (j, *_) in enumerate(self.actuators) if ready[j] != 1.0)

    @property
    def nullity(self) -> int:
        """d = working thrusters - rank T P: the freedom that is left once the wrench is met."""
        return len(self.working) - self.rank

    @cached_property
    def f_scale(self) -> float:
        """Largest limit of any thruster [N]; thrust tolerances are relative to it."""
        return float(max(np.abs(self.f_min).max(), np.abs(self.f_max).max()))

    @cached_property
    def row_lengths(self) -> FloatArray:
        """(k,) length of each row of T: dividing by it makes newtons and newton metres alike.

        A row that no thruster moves (0, or rounding such as cos 90 deg) gets the length of the longest
        row, so that the quotient is defined and the row stays zero.
        """
        if self.units is not None:
            return _frozen(self.units.copy())
        own = np.linalg.norm(self.T, axis=1)
        longest = own.max()
        return _frozen(np.where(own > RANK_TOLERANCE * longest, own, longest))

    @cached_property
    def directions(self) -> Directions:
        """Directions of wrench with their authority and what the survey's tolerance makes of nothing."""
        far = np.maximum(np.abs(self.f_min), np.abs(self.f_max))
        far = np.where(far > 0.0, far, self.f_scale)  # limits of zero are a choice, no loss
        return directions(self.T, self.readiness, far, self.dof, self.survey, self.poses)

    @cached_property
    def counts(self) -> FloatArray:
        """(k,) share to which each of the ``directions`` counts: 0 of a weak or lost one, 1 of most [-]."""
        return _frozen(self.directions.counts(self.rank, self.weak_limit))

    @cached_property
    def entry_counts(self) -> FloatArray:
        """(k, n) share to which each entry of T couples its axis with others: 0 of noise, 1 of most [-].

        As ``counts``, of an entry and its own error; in place of sigma / sigma_max is its size over the
        largest one's.
        """
        if self.weak_limit is None:
            errors = doubts(self.T, self.dof, self.survey, np.eye(self.k), self.poses)
            return _frozen(couplings(np.abs(self.T), WEAK * np.sqrt(errors)))
        sizes = np.abs(self.T) / self.directions.scale[:, None]
        return _frozen(couplings(sizes, np.full(sizes.shape, self.weak_limit * sizes.max())))

    @property
    def weak(self) -> FloatArray:
        """(m, k) rows c, applied as c'tau, of the directions that methods with a share leave out."""
        rows = self.directions.rows[self.counts == 0.0]
        longest = np.abs(rows).max(axis=1, initial=0.0, keepdims=True)
        return np.where(np.abs(rows) > RANK_TOLERANCE * longest, rows, 0.0)

    @property
    def weak_left(self) -> FloatArray:
        """(m,) sigma / sigma_max of each weak direction [-]; 0 where no thruster pushes along it."""
        sigma, weak = self.directions.sigma, np.flatnonzero(self.counts == 0.0)
        left, pushed = np.zeros(len(weak)), weak < self.rank
        left[pushed] = sigma[weak[pushed]] / sigma[0]
        return left

    @property
    def strong(self) -> "Vehicle":
        """This vehicle with T that pushes nothing along its weak directions; itself where it has none.

        Of directions that are lost already only a short row of T makes another vehicle, by the length that it
        counts with. Where failures leave all directions weak it is the vehicle itself. Raises VehicleError
        where they are weak without any failure.
        """
        return self.mixture[-1][1]

    @cached_property
    def mixture(self) -> "tuple[tuple[float, Vehicle], ...]":
        """Vehicles whose answers methods with a share mix, each with its w [-]; mostly (1, ``strong``) alone.

        Directions whose ``counts`` w lie between 0 and 1 are pushed by the last, ``strong``, and not by the
        first; each of the others pushes one more than that before, the largest w first. With f_j the answer
        of the j-th the mixture is f = f_0 + sum_j w_j (f_j - f_j-1). It lies within limits, and makes 1 - w
        of what f_0 makes along such a direction unasked. Raises as ``strong``.
        """
        if self.units is not None or (self.faults and not self.counts.any()):
            return ((1.0, self),)
        if not self.counts.any():
            raise VehicleError(f"{self.name}: {ALL_WEAK}", "weak")
        return tuple((w, self._without(weak)) for w, weak in omissions(self.counts))

    def _without(self, weak: IndexArray) -> "Vehicle":
        """This vehicle with T that pushes nothing along these of its ``directions``."""
        pushed = weak[weak < self.rank]
        T, units = self.directions.strong_rows(self.T, self.row_lengths, pushed, self.working)
        if not weak.size or (not pushed.size and (units == self.row_lengths).all()):
            return self
        return replace(self, T=T, units=units, weak_limit=0.0)

    @cached_property
    def wrench_scale(self) -> FloatArray:
        """(k,) size of a wrench on each axis [N, N m]: ``row_lengths`` times ``f_scale``.

        Wrench tolerances are relative to this scale, so they mean the same on a 20 N and a 600 kN vehicle.
        """
        return self.row_lengths * self.f_scale

    def limits(
        self,
        *,
        volts: float | None = None,
        f_previous: ArrayLike | None = None,
        dt: float | None = None,
        blocked: Sequence[int | str] = (),
        angles: ArrayLike | None = None,
    ) -> Interval:
        """f_min and f_max (n,) of this moment [N]: this vehicle's own, intersected with all that is given.

        Parameters
        ----------
        volts : of the battery [V]; limits are interpolated linearly in the vehicle's table
        f_previous, dt : (n,) thrusts of the last call [N] and the time since [s]; slew rates bound the change
        blocked : thrusters, by index or name, that give nothing now, as one out of the water
        angles : (m,) last angle of each thruster [deg], for those that turn and gave no force; else they are
            where they rest

        Returns
        -------
        f_min, f_max : (n,) fresh arrays, 0 for a thruster that is off or blocked; f_min exceeds f_max where
            what is given contradicts itself, as slew rates do that can't follow a voltage. Where thrusters
            turn they are boxes around polygons, and both together are ``limits`` of a call

        Raises
        ------
        VehicleError where the vehicle has no table or no slew rates, DemandError for a voltage outside of the
        table, and for what is no thrusts, no time or no thruster.
        """
        if self.azimuths and volts is None:
            if blocked:
                refuse_azimuths(self.azimuths, "vehicle.limits(blocked=…)", "take vehicle.with_fault")
            own, turning = (self.f_min, self.f_max), (self.azimuths, self.readiness)
            return sets_of_a_moment(self.name, own, *turning, self.slew, f_previous, dt, angles)
        own = self.f_min, self.f_max
        low, high = of_a_moment(self.name, own, self.by_volts, self.slew, volts, f_previous, dt)
        still = self.readiness == 0
        try:
            still[[self.index(thruster) for thruster in blocked]] = True
        except VehicleError as error:
            raise DemandError(error.what) from None
        return np.where(still, 0.0, low), np.where(still, 0.0, high)

    def commands(
        self,
        f: ArrayLike,
        volts: ArrayLike | None = None,
        *,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        cap: ArrayLike | None = None,
    ) -> Sent:
        """Commands to the ESCs for thrusts f (n,) or (N, n) [N], and the thrusts that they make.

        The inverse of the curve in the vehicle's ``esc``, rounded to the nearest step; what is made lies
        within the limits where a step does. A thrust that is no number gives neutral.

        Parameters
        ----------
        f : the thrusts
        volts : of the battery, one or (N,) [V]; left out, the nominal voltage of the curve
        f_min, f_max : (n,) or (N, n) limits of the call [N]; left out, the vehicle's
        cap : on the sum of currents, one or (N,) [A]: where rounding exceeds it, commands are rounded towards
            neutral

        Raises VehicleError where the vehicle has no ``esc``, DemandError for another shape and where the
        curve has several voltages and nothing says which.
        """
        low, high = self.f_min if f_min is None else f_min, self.f_max if f_max is None else f_max
        return esc_commands(self.name, self.esc, f, volts, low, high, cap)

    def esc_limits(
        self,
        volts: ArrayLike | None = None,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
    ) -> Interval:
        """f_min and f_max (n,) or (N, n) [N] of a call, cut at the ends of the curves at its voltage.

        Thrusts allocated within are made to the steps of the commands, so the shares of such an answer are
        those of what the ESCs make. Limits wholly beyond the curve become its end; limits that cross stay so.

        Parameters and errors are those of ``commands``.
        """
        low, high = self.f_min if f_min is None else f_min, self.f_max if f_max is None else f_max
        return esc_limits(self.name, self.esc, volts, low, high)

    def thrusts(self, commands: ArrayLike, volts: ArrayLike | None = None) -> FloatArray:
        """Thrusts (n,) or (N, n) [N] that commands of that shape make: the way back of ``commands``.

        Commands beyond the range make what its end makes, NaN makes NaN. Raises as ``commands``.
        """
        return esc_thrusts(self.name, self.esc, commands, volts)

    def draw(self, volts: float | None = None) -> Draw:
        """The current of each thruster by its thrust, at a voltage [V]; left out, the nominal one.

        ``vehicle.draw(12.0).amps(f)`` is (n,) or (N, n) [A]. Raises VehicleError where the file says no
        currents, DemandError as ``commands``.
        """
        return esc_draw(self.name, self.esc, volts)

    def with_fault(self, thruster: int | str, readiness: float = 0.0) -> "Vehicle":
        """This vehicle with one thruster off, or weakened: p_ii = ``readiness`` (eq. 2).

        The thruster is given by its index, counted from 0, or by its name. A thruster that is off has
        f_i = 0 and limits of 0; switching it off again changes nothing. Raises VehicleError for an index
        outside 0 … n - 1, an unknown name, a readiness outside [0, 1], and for readiness
        above 0 of a thruster that is off, whose limits are no longer known.
        """
        i = self.index(thruster)
        components = list(self.actuators[i])
        if self.readiness[components[0]] == 0:
            if readiness == 0:
                return self
            raise VehicleError(
                f"{self.name}: {self.called(i)} is off, and its limits with it; weaken it on the vehicle "
                "on which it still works"
            )
        P = self.readiness.copy()
        P[components] = readiness
        suffix = f"-f{i}" if readiness == 0 else f"-f{i}@{readiness:g}"
        return replace(self, name=self.name + suffix, readiness=P, whole=self.whole or self.name)

    def with_frame(self, frame: str) -> "Vehicle":
        """This vehicle in the frame ``frd`` or ``flu``: T, and with it every wrench, turned about x.

        The same demand, turned, gives the same thrusts. Raises VehicleError for another frame.
        """
        wanted = checked_frame(frame)
        if wanted != self.frame:
            refuse_azimuths(self.azimuths, "with_frame", "polygons are not turned; write the file anew")
        T, poses = turned(self.T, self.dof), None if self.poses is None else turned(self.poses, DOF)
        return self if wanted == self.frame else replace(self, T=T, poses=poses, frame=wanted)


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array.setflags(write=False)
    return array
