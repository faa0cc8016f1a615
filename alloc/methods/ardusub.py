"""ArduSub's mixer: a table of factors for each input, summed and cut; two frames temper it first."""

from functools import reduce
from itertools import product as combinations
from operator import add
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.errors import NotApplicable
from alloc.formulations.ardusub import FORMULATION as ANSWERED
from alloc.kernels import rules
from alloc.kernels.entry import SeenArguments, all_thrusters, clamp_thrusts, refuse
from alloc.program import Builder, Expression, Program, Scalar, Where, clamp, least, most, select, size
from alloc.program.sums import Terms, product, shared_sums, signed
from alloc.vehicle import Vehicle
from alloc.vehicle.autopilot import SENSE, Autopilot
from alloc.vehicle.geometry import DOF

FORMULATION = ANSWERED.name
MEANINGS = rules.MEANINGS
doubt = rules.doubt

FORWARD, THROTTLE = DOF.index("surge"), DOF.index("heave")
UPWARDS = [DOF.index(axis) for axis in ("heave", "roll", "pitch")]
LEVEL = [DOF.index(axis) for axis in ("surge", "sway", "yaw")]
"""Inputs that VECTORED_6DOF scales together."""
FRONT, REAR = (1, 2), (3, 4)
"""Motors of VECTORED whose share of forward gives way to throttle: FRONT going astern, REAR going ahead."""
NOTHING = 1e-9
"""Share of what all thrusters could do along an axis below which factors command nothing of it [-]."""

SAME = 1e-12
"""Share by which both ways along an axis may differ by rounding [-]."""

ROUNDINGS = 8
"""Roundings of a group's fit in C: from its inputs' sizes to a thrust."""


class InputScales(NamedTuple):
    """The way from a wrench to the six inputs.

    Attributes
    ----------
    axes : (k,) input of each axis of the vehicle, an index of DOF
    ahead, astern : (k,) input for 1 N or 1 N m, above and below zero [1/N, 1/(N m)]; 0 for an axis that the
        factors don't command
    """

    axes: list[int]
    ahead: FloatArray
    astern: FloatArray


def build(vehicle: Vehicle) -> Saturating:
    """Prepare f = thrust(mix(inputs(tau))) with the factors of the vehicle's ``autopilot``.

    After AP_Motors6DOF; ``alloc.vehicle.autopilot`` names the commit. An input is the demand along its axis
    over what input 1 makes there on this geometry, or over the user's gain, cut at 1. The firmware's pulse is
    linear in an output, and its thrust that of the vehicle's ``esc`` at its nominal voltage, else linear from
    f_min at -1 to f_max at 1. ``thrust: linear`` in the file leaves the curve to control loops, which make up
    for it until outputs near their ends (docs/autopilot.md). Neither a failed thruster nor limits of the call
    change an output; thrusts are cut at them. Raises NotApplicable where the vehicle has no ``autopilot``, or
    several curves and no voltage.
    """
    mixer, way = find_mixer(vehicle), find_inputs(vehicle)
    ready = vehicle.readiness != 0

    def each(taus: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        made: FloatArray = output_thrusts(vehicle, mixer, outputs(mixer, inputs(way, taus))) * ready
        return made

    def one(tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        made: list[float] = each(tau[None], tau, tau, tau)[0].tolist()
        return made, 1

    return Saturating(vehicle, FORMULATION, one, each, start=np.zeros((vehicle.n, vehicle.k)))


def find_mixer(vehicle: Vehicle) -> Autopilot:
    """The vehicle's autopilot; raises NotApplicable where it has none, or PX4."""
    if vehicle.autopilot is None or vehicle.autopilot.method != "ardusub":
        has = "no key 'autopilot'" if vehicle.autopilot is None else "PX4 as its autopilot"
        raise NotApplicable(
            f"ardusub: {vehicle.whole or vehicle.name} has {has}; write autopilot: {{ardusub: FRAME}}"
        )
    if vehicle.autopilot.curve and any(esc.needs_volts for esc in vehicle.esc):
        raise NotApplicable(
            f"ardusub: {vehicle.whole or vehicle.name} has several curves; write volts in 'esc',"
            " or thrust: linear in 'autopilot'"
        )
    return vehicle.autopilot


def find_inputs(vehicle: Vehicle) -> InputScales:
    """The way to inputs: by the user's gains, else by what inputs 1 and -1 give on this geometry."""
    mixer = find_mixer(vehicle)
    axes = [DOF.index(axis) for axis in vehicle.dof]
    scales = np.zeros((2, vehicle.k))
    for row, (axis, T) in enumerate(zip(axes, vehicle.T, strict=True)):
        sense = SENSE[vehicle.frame][axis]
        most_there = np.abs(T) @ np.abs(mixer.thrust).max(axis=0)
        for side, sign in enumerate(
            (sense, -sense)
        ):  # along +axis the input is +1 where both point the same way
            given = mixer.gains.get(
                DOF[axis], abs(T @ output_thrusts(vehicle, mixer, sign * mixer.factors[:, axis]))
            )
            scales[side, row] = sense / given if given > NOTHING * most_there else 0.0
        if abs(scales[1, row] - scales[0, row]) <= SAME * abs(scales[0, row]):
            scales[1, row] = scales[0, row]  # one product less in C
    return InputScales(axes, *scales)


def inputs(way: InputScales, taus: FloatArray) -> FloatArray:
    """The six inputs (N, 6), within 1, of wrenches (N, k) [N, N m]."""
    found = np.zeros((len(taus), len(DOF)))
    found[:, way.axes] = np.clip(np.where(taus > 0, way.ahead, way.astern) * taus, -1.0, 1.0)
    return found


def outputs(mixer: Autopilot, asked: FloatArray) -> FloatArray:
    """Outputs (N, n), within 1, of inputs (N, 6): the three ways of the firmware."""
    B = mixer.factors
    if mixer.frame == "VECTORED_6DOF":
        total = sum(_fitted(asked[:, part] @ B[:, part].T) for part in (UPWARDS, LEVEL))
    else:
        total = asked @ B.T
        if mixer.frame == "VECTORED":
            left = np.maximum(1.0 - mixer.coupling * np.abs(asked[:, THROTTLE]), 0.0)
            forward = asked[:, FORWARD]
            over = forward - np.clip(forward, -left, left)
            gives_way = [(motor in FRONT, motor in REAR) for motor in mixer.motors]
            cut = np.array([over.clip(max=0.0) * a + over.clip(min=0.0) * b for a, b in gives_way]).T
            total = total - cut * B[:, FORWARD]
    made: FloatArray = np.clip(total, -1.0, 1.0)
    return made


def _fitted(part: FloatArray) -> FloatArray:
    """Outputs (N, n) over the largest of each row, where that is above 1."""
    fitted: FloatArray = part / np.maximum(np.abs(part).max(axis=1, keepdims=True), 1.0)
    return fitted


def thrust(mixer: Autopilot, made: FloatArray) -> FloatArray:
    """Thrusts (…, n) [N] of outputs: linear on either side of zero."""
    astern, ahead = mixer.thrust
    f: FloatArray = made * np.where(made > 0, ahead, -astern)
    return f


def output_thrusts(vehicle: Vehicle, mixer: Autopilot, made: FloatArray) -> FloatArray:
    """Thrusts (…, n) [N] of outputs: through the curves of ``esc`` where the autopilot has them."""
    if not mixer.curve:
        return thrust(mixer, made)
    neutral, low, high, turned = np.array(
        [(esc.neutral, esc.low, esc.high, -1.0 if esc.reversed else 1.0) for esc in vehicle.esc]
    ).T
    along = turned * made
    return vehicle.thrusts(neutral + along * np.where(along < 0.0, neutral - low, high - neutral))


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same for a demand within any limits, without a branch.

    75 operations on bluerov2, 74 of clip. 101 operations on bluerov2-heavy, 79 of clip: each of its eight
    thrusts is the larger of two values, as each of clip's is cut twice; two groups take 16 each to cut and
    scale. Raises NotApplicable where thrust goes through the curves of ``esc``.
    """
    mixer, way = find_mixer(vehicle), find_inputs(vehicle)
    if mixer.curve:
        raise NotApplicable(
            f"ardusub: its C has no curve of an ESC; write thrust: linear in 'autopilot' of {vehicle.name}"
        )
    builder = Builder(vehicle, limits, scalar)
    full = next((float(side[0]) for side in np.abs(mixer.thrust) if side[0] > 0 and np.ptp(side) == 0), 1.0)
    mixed = _fitted_mix if mixer.frame == "VECTORED_6DOF" else _cut_mix
    u = [signed(row, builder.graph) for row in mixed(builder, mixer, way, full)]
    astern, ahead = (mixer.thrust / full).tolist()
    x = {i: rules.sided(u[i], ahead[i], -astern[i]).named(f"x{i}") for i in vehicle.working.tolist()}
    astern, ahead = mixer.thrust.tolist()
    if builder.limits.at_call and mixed is _cut_mix:
        x = {i: clamp(value, astern[i], ahead[i]) for i, value in x.items()}
    still = (vehicle.f_min <= 0.0).all() and (vehicle.f_max >= 0.0).all()
    inside = mixed is _fitted_mix and still and not builder.limits.at_call
    f = x if inside else clamp_thrusts(builder, x, builder.limits)
    missed, at_most = rules.wrench_missed(builder, f)
    seen = SeenArguments([], builder)
    seen.add(vehicle.working.tolist(), "0")
    seen.sums.append(missed)  # each entry of tau is a term, and no cut hides it
    refuse(builder, seen, [], exact=False)
    met = (missed <= at_most).named("met")
    builder.compute(met)
    return builder.program(all_thrusters(builder, f), select(met, Status.SOLVED, Status.PARTIAL))


def _asked(builder: Builder, way: InputScales, factors: FloatArray) -> list[Expression]:
    """The six inputs times ``factors`` (6,), not yet cut.

    A product that ``wrench_missed`` has too, but for rounding, is made once for both.
    """
    asked: list[Expression] = [builder.graph.constant(0.0)] * len(DOF)
    shared = rules.unit_errors(builder)[1].tolist()
    for axis, tau, *sides, known in zip(way.axes, builder.tau, way.ahead, way.astern, shared, strict=True):
        up, down = (factors[axis] * side for side in sides)
        if up == down and abs(up - known) <= SAME * known:
            up = down = known
        asked[axis] = rules.sided(tau, up, down).named(f"i{axis}")
    return asked


def _cut_mix(builder: Builder, mixer: Autopilot, way: InputScales, full: float) -> list[Terms]:
    """Outputs of inputs, not yet cut, as sums; ``full`` stands for 1 of both.

    Inputs are turned about, so that few rows are negative: a sign before a whole row is an instruction.
    """
    B = mixer.factors
    ways: list[tuple[float, ...]] = [(1.0, -1.0)] * len(DOF)
    if mixer.frame == "VECTORED":
        ways[FORWARD] = (1.0,)  # ahead and astern give way on different motors
    signs = np.array(min(combinations(*ways), key=lambda each: int((B * each <= 0.0).all(axis=1).sum())))
    B = B * signs
    asked = [clamp(value, -full, full) for value in _asked(builder, way, full * signs)]
    if mixer.frame == "VECTORED":
        left = full - mixer.coupling * size(asked[THROTTLE])
        left = (most(left, 0.0) if mixer.coupling > 1.0 else left).named("left")
        forward = asked[FORWARD]
        asked += [most(forward, -left).named("front"), least(forward, left).named("rear")]
        B = np.hstack([B, np.zeros((len(B), 2))])
        for i, motor in enumerate(mixer.motors):
            for column, gives_way in ((len(DOF), FRONT), (len(DOF) + 1, REAR)):
                if motor in gives_way:
                    B[i, column], B[i, FORWARD] = B[i, FORWARD], 0.0
    return shared_sums(product(B, asked, "p").rows, "w")[1]


def _fitted_mix(builder: Builder, mixer: Autopilot, way: InputScales, full: float) -> list[Terms]:
    """Outputs of VECTORED_6DOF: inputs cut, and over the largest output of their group where it is above 1.

    A group has a motor for each choice of signs, so its largest output is the sum of its inputs' sizes. It
    ends a few roundings below 1, so no sum of its inputs needs another cut. A group's inputs are in the unit
    in which ``wrench_missed`` has their parts of tau; the division brings them back.
    """
    signs, ratios = np.ones(len(DOF)), np.zeros(len(DOF))
    signs[way.axes] = np.where(way.ahead < 0.0, -1.0, 1.0)
    ratios[way.axes] = full * np.abs(way.ahead) / rules.unit_errors(builder)[1]
    unit = np.finfo(np.float32 if builder.scalar == "float" else np.float64).eps
    room = full * (1.0 - ROUNDINGS * float(unit))
    longer = np.ones(len(DOF))
    for part in (UPWARDS, LEVEL):
        if (known := ratios[part][ratios[part] > 0.0]).size:
            longer[part] = 1.0 / np.median(known)
    fitted = _asked(builder, way, full * signs * longer)
    for part in (UPWARDS, LEVEL):
        reach = room * float(longer[part[0]])
        cut = [clamp(fitted[axis], -reach, reach) for axis in part]
        load: Expression = reduce(add, map(size, cut))
        share = room / most(load, reach)
        for axis, value in zip(part, cut, strict=True):
            fitted[axis] = share * value
    return shared_sums(product(mixer.factors * signs, fitted, "p").rows, "w")[1]
