"""PX4's allocation of an underwater vehicle: a scaled pseudoinverse, then axes give way one by one."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray, Status
from alloc.closed_forms.balance import balancing_step
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.errors import NotApplicable
from alloc.formulations.px4 import FORMULATION as ANSWERED
from alloc.kernels import rules
from alloc.kernels.entry import TAU, SeenArguments, all_thrusters, clamp_thrusts, refuse
from alloc.program import Builder, Expression, Program, Scalar, Where, clamp, least, most, select, size
from alloc.program.sums import product, shared_sums, signed
from alloc.vehicle import Vehicle
from alloc.vehicle.autopilot import PX4_FRAMES, SENSE, px4_coefficients
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import DOF
from alloc.vehicle.limits import Interval

FORMULATION = ANSWERED.name
MEANINGS = rules.MEANINGS
doubt = rules.doubt
NAMED_ONLY = True  # what PX4 does with any vehicle: of interest to who flies it

FORCES, ROLL, PITCH, YAW, HEAVE = slice(0, 3), 3, 4, 5, 2
"""Places in DOF."""
MARGINAL = 0.05
"""Largest entry of a row of the effectiveness up to which PX4 gives up the axis [CT, CT m]."""
SMALL = 1e-3
"""Entry of the pseudoinverse, and of its scaled columns, that counts as 0 [-]."""
EPSILON = 2.0**-23
"""PX4's FLT_EPSILON: a scale below divides nothing [-]."""
WEAK = 0.2
"""Entry of a scaled column below which an output does not give way along it [-]."""
YAW_MARGIN = 0.15
"""Share of an output's range by which yaw may exceed it, at the cost of heave [-]."""
STOPPED = 0.02
"""Output below which a motor is stopped [-]."""

Limits = list[tuple[float, float]]


class Mixing(NamedTuple):
    """PX4's two matrices of a vehicle.

    Attributes
    ----------
    effectiveness : (6, n) force and moment of each output at 1, rows as DOF, in frd [CT, CT m]
    mix : (n, 6) outputs of each setpoint at 1 [-]
    scales : (6,) setpoint of the force or moment 1 [1/CT, 1/(CT m)]
    """

    effectiveness: FloatArray
    mix: FloatArray
    scales: FloatArray


def build(vehicle: Vehicle) -> Saturating:
    """Prepare f = thrust(u), u PX4's outputs with the parameters of ``export --format px4``.

    After PX4/PX4-Autopilot v1.16.0 (6ea3539157ca): CA_AIRFRAME 7, CA_METHOD and MC_AIRMODE of the vehicle's
    ``autopilot``. v1.16.1 (94cb2012792b) and v1.17.0-beta1 (15f5fefa0c7c) have the same text of the
    pseudoinverse and the desaturation, v1.14.2 (968732477803) the same equations. Later main stops no small
    outputs (3f0d0ebc10, July 2026), and has MC_AIRMODE_LIM in place of MC_AIRMODE (00202eb379b7).
    Thrust is linear in an output, from f_min at -1 to f_max at 1; PX4 takes it as alike on both sides. A
    thruster that is off is out of the effectiveness, as CA_FAILURE_MODE 1 has it; where the vehicle's
    ``autopilot`` is PX4, CT and scales stay those of the whole vehicle. Limits of the call cut outputs
    afterwards, as CA_Rn_SLEW does. Left out: UUV_THRUST_SAT and UUV_TORQUE_SAT, which cut setpoints before.
    Raises NotApplicable where a working thruster has no f_max above 0 to be its CT.
    """
    mixing, unit, limits = _limited_mixing(vehicle)
    mix_all = _rule(vehicle)
    low, high = _rated(vehicle)
    axes = [DOF.index(axis) for axis in vehicle.dof]

    def one(tau: FloatArray, f: list[float], call: Bounds) -> tuple[list[float], int]:
        asked = np.zeros(len(DOF))
        asked[axes] = (tau if vehicle.frame == "frd" else turned(tau, vehicle.dof)) / unit
        u = stop_small(mix_all(mixing.mix, asked * mixing.scales, limits), limits)
        made: list[float] = (u * np.where(u > 0, high, -low)).tolist()
        return made, 1

    return Saturating(vehicle, FORMULATION, one, start=np.zeros((vehicle.n, vehicle.k)))


def unit_outputs(vehicle: Vehicle) -> FloatArray:
    """Outputs (n, 6) for each setpoint at 1, columns as DOF, heave upwards; raises as ``build``."""
    mixing, _, limits = _limited_mixing(vehicle)
    mix_all = _rule(vehicle)
    setpoints = np.diag(np.array(SENSE["frd"]))
    made: FloatArray = np.array([stop_small(mix_all(mixing.mix, one, limits), limits) for one in setpoints]).T
    return made


def _limited_mixing(vehicle: Vehicle) -> tuple[Mixing, float, Limits]:
    low, high = _rated(vehicle)
    coefficients, unit = px4_coefficients(high)
    if not (coefficients[vehicle.working] > 0).all():
        raise NotApplicable(f"px4: f_max of a thruster of {vehicle.name} is not above 0, so it has no CT")
    limits = [(-1.0 if end < 0 else 0.0, 1.0) for end in low.tolist()]
    return make_mixing(_rows(vehicle) * coefficients, vehicle.readiness != 0), unit, limits


def _rated(vehicle: Vehicle) -> Interval:
    """Thrusts (n,) at outputs -1 and 1 [N], of failed thrusters too where the ``autopilot`` is PX4."""
    mixer = vehicle.autopilot
    known = mixer is not None and mixer.method == "px4"
    return (mixer.thrust[0], mixer.thrust[1]) if mixer and known else (vehicle.f_min, vehicle.f_max)


def _rule(vehicle: Vehicle) -> Callable[[FloatArray, FloatArray, Limits], FloatArray]:
    """The outputs of setpoints by the vehicle's CA_METHOD and MC_AIRMODE; automatic and 0 without a key."""
    mixer = vehicle.autopilot
    if mixer is not None and mixer.frame == PX4_FRAMES["pseudoinverse"]:
        return lambda mix, asked, _: mix @ asked
    return partial(desaturated, airmode=0 if mixer is None else mixer.airmode)


def _rows(vehicle: Vehicle) -> FloatArray:
    """(6, n) force and moment of each thrust in frd: those of poses, else the rows of T."""
    rows = np.zeros((len(DOF), vehicle.n))
    rows[[DOF.index(axis) for axis in vehicle.dof]] = vehicle.T
    if vehicle.poses is not None:
        rows = vehicle.poses
    return rows if vehicle.frame == "frd" else turned(rows, DOF)


def make_mixing(
    effectiveness: FloatArray, ready: BoolArray | None = None, *, normalize: bool = True
) -> Mixing:
    """The scaled pseudoinverse of an effectiveness (6, n), moments unscaled without ``normalize``.

    Columns outside of ``ready`` (n,) are failed: scales are those of all columns. Roll and pitch share one
    scale, the larger of both columns' lengths over the root of half their number of entries; yaw's is its
    largest entry; a force's the mean size of its entries.
    """
    left = _without_marginal(effectiveness if ready is None else effectiveness * ready)
    mix = np.asarray(np.linalg.pinv(_without_marginal(effectiveness)), dtype=np.float64)
    scales = np.ones(len(DOF))
    if normalize:
        scales[[ROLL, PITCH]] = max(_root(mix[:, ROLL]), _root(mix[:, PITCH]))
        scales[YAW] = mix[:, YAW].max(initial=0.0)
    for axis in (2, 1, 0):
        entries = np.abs(mix[:, axis])
        there = np.count_nonzero(entries > EPSILON)
        scales[axis] = entries.sum() / there if there else scales[HEAVE]
    scales = np.where(_divides(scales), scales, 1.0)
    if ready is not None and not ready.all():
        mix = np.asarray(np.linalg.pinv(left), dtype=np.float64)
    mix /= scales
    mix[np.abs(mix) < SMALL] = 0.0
    return Mixing(left, mix, scales)


def _without_marginal(rows: FloatArray) -> FloatArray:
    there: FloatArray = np.where(np.abs(rows).max(axis=1, keepdims=True) > MARGINAL, rows, 0.0)
    return there


def _root(column: FloatArray) -> float:
    there = np.count_nonzero(np.abs(column) > SMALL)
    return float(np.sqrt((column @ column) / (there / 2))) if there else 1.0


def _divides(scales: FloatArray) -> BoolArray:
    """(6,) scales that divide: all forces by surge's, roll and pitch by roll's."""
    asked = scales > EPSILON
    asked[FORCES], asked[PITCH] = asked[0], asked[ROLL]
    return asked


def desaturated(mix: FloatArray, asked: FloatArray, limits: Limits, airmode: int = 0) -> FloatArray:
    """Outputs (n,) of six setpoints: heave, roll, pitch, then yaw give way; surge and sway never do.

    With airmode 0 heave only moves towards +z, which is less thrust of a multirotor, so that a vehicle that
    pushes itself down saves roll and pitch less than one that pushes itself up. With 1 heave moves both ways
    and roll and pitch don't give way; with 2 yaw is served with them, and alone gives way after heave.
    """
    columns = mix.T
    if airmode == 2:
        u = _giving_way(mix @ asked, columns[HEAVE], limits)
        return _giving_way(u, columns[YAW], limits)
    without_yaw = asked.copy()
    without_yaw[YAW] = 0.0
    u = _giving_way(mix @ without_yaw, columns[HEAVE], limits, only_up=airmode == 0)
    for axis in (ROLL, PITCH) if airmode == 0 else ():
        u = _giving_way(u, columns[axis], limits)
    wide = [(low, high + YAW_MARGIN * (high - low)) for low, high in limits]
    u = _giving_way(u + columns[YAW] * asked[YAW], columns[YAW], wide)
    return _giving_way(u, columns[HEAVE], limits, only_up=True)


def _giving_way(u: FloatArray, column: FloatArray, limits: Limits, *, only_up: bool = False) -> FloatArray:
    """Outputs moved along a column by the balancing step and half of a second one."""
    entries = column.tolist()
    first = balancing_step(u.tolist(), entries, limits, WEAK)
    if only_up and first < 0.0:
        return u
    u = u + first * column
    made: FloatArray = u + 0.5 * balancing_step(u.tolist(), entries, limits, WEAK) * column
    return made


def stop_small(u: FloatArray, limits: Limits) -> FloatArray:
    """Outputs cut at their limits, those below STOPPED 0."""
    low, high = np.array(limits).T
    made: FloatArray = np.where(np.abs(u) < STOPPED, 0.0, np.clip(u, low, high))
    return made


def unallocated(mixing: Mixing, asked: FloatArray, u: FloatArray) -> FloatArray:
    """(6,) setpoints that PX4 reports as not allocated by outputs u (n,) (control_allocator_status)."""
    left: FloatArray = asked - (mixing.effectiveness @ u) * mixing.scales
    return left


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same for a demand within any limits: at most ten balancing steps, whatever is asked."""
    mixing, unit, ends = _limited_mixing(vehicle)
    low, high = (side.tolist() for side in _rated(vehicle))
    builder = Builder(vehicle, limits, scalar)
    seen = SeenArguments([(TAU, j) for j in range(vehicle.k)], builder)
    seen.add(vehicle.working.tolist(), "0")
    refuse(builder, seen, [], exact=False)
    u, x = _outputs(builder, mixing, unit, ends), {}
    for i in vehicle.working.tolist():
        cut = clamp(u[i], *ends[i])
        kept = select(size(cut) < STOPPED, 0.0, cut).named(f"u{i}")
        x[i] = rules.sided(kept, high[i], -low[i] if ends[i][0] else high[i]).named(f"x{i}")
    f = clamp_thrusts(builder, x, builder.limits)
    met = rules.makes_tau(builder, f)
    builder.compute(met)
    return builder.program(all_thrusters(builder, f), select(met, Status.SOLVED, Status.PARTIAL))


def _outputs(builder: Builder, mixing: Mixing, unit: float, ends: Limits) -> list[Expression]:
    """Outputs of the demand, not yet cut, as ``_rule`` has them."""
    vehicle, mixer, graph = builder.vehicle, builder.vehicle.autopilot, builder.graph
    axes = [DOF.index(axis) for axis in vehicle.dof]
    sense = np.ones(vehicle.k) if vehicle.frame == "frd" else turned(np.ones(vehicle.k), vehicle.dof)
    of_tau = mixing.mix[:, axes] * mixing.scales[axes] * sense / unit
    plain = mixer is not None and mixer.frame == PX4_FRAMES["pseudoinverse"]
    airmode = 0 if mixer is None else mixer.airmode
    last = [] if plain or airmode == 2 or "yaw" not in vehicle.dof else [vehicle.dof.index("yaw")]
    first = of_tau.copy()
    first[:, last] = 0.0
    u = [signed(row, graph) for row in shared_sums(product(first, builder.tau, "p").rows, "w")[1]]
    if plain:
        return u

    def give_way(u: list[Expression], axis: int, limits: Limits = ends, up: bool = False) -> list[Expression]:
        return _moved(builder, u, mixing.mix[:, axis].tolist(), limits, only_up=up)

    u = give_way(u, HEAVE, up=airmode == 0)
    if airmode == 2:
        return give_way(u, YAW)
    for axis in (ROLL, PITCH) if airmode == 0 else ():
        u = give_way(u, axis)
    for j in last:
        u = _along(u, of_tau[:, j].tolist(), builder.tau[j])
    u = give_way(u, YAW, [(low, high + YAW_MARGIN * (high - low)) for low, high in ends])
    return give_way(u, HEAVE, up=True)


def _moved(
    builder: Builder, u: list[Expression], column: list[float], limits: Limits, *, only_up: bool
) -> list[Expression]:
    """The same of ``_giving_way`` in a program."""
    if not any(abs(c) >= WEAK for c in column):
        return u
    first = _balanced(u, column, limits)
    builder.compute(first)
    moved = _along(u, column, most(first, 0.0) if only_up else first)
    half = 0.5 * _balanced(moved, column, limits)
    return _along(moved, column, select(first < 0.0, 0.0, half) if only_up else half)


def _balanced(u: list[Expression], column: list[float], limits: Limits) -> Expression:
    """The balancing step in a program, along a column that some output gives way to."""
    beside = zip(u, column, limits, strict=True)
    steps = [(clamp(value, *ends) - value) * (1.0 / c) for value, c, ends in beside if abs(c) >= WEAK]
    found: Expression = least(*steps, 0.0) + most(*steps, 0.0)
    return found


def _along(u: list[Expression], column: list[float], step: Expression) -> list[Expression]:
    return [value + c * step if c else value for value, c in zip(u, column, strict=True)]
