"""Capability of a vehicle after each failure, and the share of it that each method serves."""

from collections.abc import Sequence
from itertools import product
from math import isfinite, prod
from typing import NamedTuple, cast

import numpy as np

from alloc import Allocation, Label, NotApplicable, Status, Vehicle, alpha_max
from alloc.allocation import FloatArray
from alloc.errors import SolverError
from alloc.reach.attainable import alpha_range, closed_form_range
from alloc.reach.volumes import (
    attainable_volume,
    closed_form_volume,
    safe_share,
    uniform_demands,
    worst_fault,
)
from alloc.reach.zonotope import vertices
from bench.demands import DemandSet, along_axes, build_demands, labelled
from bench.demands.store import Case
from bench.demands.strong import axis_maxima, strong_demands, strong_vehicle, unasked_weak_axes
from bench.judging.cap import fuse_cost
from bench.judging.judge import judge
from bench.judging.last_metre import last_metre
from bench.judging.mixer import mixer_cost
from bench.judging.question import Answers, Ask, Question, Unanswered, questions
from bench.judging.unannounced import announced_costs, failure_costs
from bench.judging.weak import axis_costs
from bench.judging.worst import strong_error, worst_loss
from bench.record import SERVED_WITHIN, Authority, Capability, Curve, Plane, Served, Unserved

PLANES = (("surge", "sway", "yaw"), ("surge", "yaw", "sway"))
"""The two axes of each section, and the third that is held. A vehicle under way needs thrust ahead and
sideways, or ahead and turning, at once; the third axis decides how much of that is left."""

HELD = (0.0, 0.4)
"""Values of the third axis, as a share of what that axis reaches alone. Along two axes at a time a
closed form loses nothing on a symmetric vehicle; along three it does."""

ANGLES = 360
"""Rays that trace an outline; a side that spans less than two degrees may be missed."""

STRAIGHT = 1e-6
"""Sine of the turn below which points count as in line: rounding leaves 1e-12, corners turn by degrees."""

POINTS = 150
"""Demands drawn into a section: enough to show where they lie, few enough to tell apart."""

SIZES = np.linspace(0.05, 2.0, 40)
"""Demand over the edge of the attainable set in its direction."""

DIRECTIONS = 100
"""Directions in which each size is tried."""


def planes(vehicle: Vehicle, seed: int) -> list[Plane]:
    """Sections of the attainable set and of where the closed form keeps the limits, for each of HELD in turn.

    Empty for a vehicle without these axes, or that can't fly the mission. A section in which the vehicle
    can't push every way, as after a failure or where thrusters can't reverse, is left out.
    """
    wanted = [axes for axes in PLANES if set(axes) <= set(vehicle.dof)]
    if not wanted:
        return []
    try:
        mission = build_demands("mission", vehicle, seed)
    except NotApplicable:
        return []
    _, forward = axis_maxima(vehicle)
    sections = []
    for share in HELD:
        for x, y, held in wanted:
            i, j, third = (vehicle.dof.index(axis) for axis in (x, y, held))
            at = float(share * forward[third])
            attainable, closed_form = _outlines(vehicle, i, j, third, at)
            if attainable:
                drawn = [] if share else _drawn(mission, i, j)
                sections.append(
                    Plane(
                        x=x,
                        y=y,
                        held=held,
                        held_at=at,
                        attainable=attainable,
                        closed_form=closed_form,
                        demands=drawn,
                    )
                )
    return sections


def _outlines(
    vehicle: Vehicle, i: int, j: int, third: int, at: float
) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Corners of the attainable and the closed form's outline in axes i and j, the third axis at ``at``."""
    angles = np.linspace(0.0, 2 * np.pi, ANGLES, endpoint=False)
    rays = np.zeros((ANGLES, vehicle.k))
    rays[:, i] = np.cos(angles) * vehicle.wrench_scale[i]
    rays[:, j] = np.sin(angles) * vehicle.wrench_scale[j]
    start = np.zeros((1, vehicle.k))
    start[0, third] = at
    seen, towards = strong_vehicle(vehicle), strong_demands(vehicle, rays)
    begin = strong_demands(vehicle, start)[0]
    attainable, closed_form = (
        # Rays from outside a set or from its edge reach only part of its outline.
        _pairs(corners(reach[:, None] * rays[:, [i, j]])) if (least < 0).all() and (reach > 0).all() else []
        for least, reach in (
            alpha_range(seen, towards, start=begin),
            closed_form_range(seen, towards, begin),
        )
    )
    return attainable, closed_form


def corners(edge: FloatArray) -> FloatArray:
    """Corners (m, 2) of the convex polygon whose edge passes through the points (n, 2), in order.

    Three or more points in line show a side; corners are where neighbouring sides meet.
    """
    size = np.abs(edge).max(axis=0)
    points = edge / size
    steps = np.roll(points, -1, axis=0) - points
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    turns = np.abs(cross(np.roll(steps, 1, axis=0), steps)) > STRAIGHT  # at each point
    on_side = ~turns | ~np.roll(turns, -1)
    first = on_side & (turns | ~np.roll(on_side, 1))  # the first step of each side
    p, d = points[first], steps[first]
    q, e = np.roll(p, -1, axis=0), np.roll(d, -1, axis=0)
    along = cross(q - p, e) / cross(d, e)
    met: FloatArray = (p + along[:, None] * d) * size
    return met


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """a x b of plane vectors (n, 2): the sine of the angle between them where both are of unit length."""
    sine: FloatArray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return sine


def _drawn(mission: DemandSet, i: int, j: int) -> list[tuple[float, float, str]]:
    pick = np.linspace(0, len(mission.taus) - 1, POINTS).astype(int)
    names = [Label(int(value)).name.lower() for value in mission.labels[pick]]
    points = _pairs(mission.taus[pick][:, [i, j]])
    return [(x, y, name) for (x, y), name in zip(points, names, strict=True)]


def demands_of_growing_size(vehicle: Vehicle, rng: np.random.Generator) -> FloatArray:
    """Demands (N, k) [N, N m]: each of SIZES in DIRECTIONS directions, size by size; size 1 is the edge."""
    strong = strong_vehicle(vehicle)
    inside = uniform_demands(strong, rng, DIRECTIONS)
    edge = inside * alpha_max(strong, inside)[:, None]
    return unasked_weak_axes(vehicle, (SIZES[:, None, None] * edge).reshape(-1, vehicle.k))


def error_curve(method: str, case: Case, F: FloatArray) -> Curve:
    """Wrench error of a method's thrusts F (N, n) for a case of ``demands_of_growing_size``."""
    error = strong_error(case.vehicle, case.taus, F).reshape(len(SIZES), DIRECTIONS)
    error = np.where(np.isnan(error), 1.0, error)  # without thrusts nothing is delivered
    return Curve(
        method=method,
        size=SIZES.round(3).tolist(),
        error_p50=np.median(error, axis=1).tolist(),
        error_max=error.max(axis=1).tolist(),
    )


def _pairs(points: FloatArray) -> list[tuple[float, float]]:
    return [(float(f"{a:.6g}"), float(f"{b:.6g}")) for a, b in points.tolist()]


AXES = 60
"""Demands along axes that are checked, beside none and those on two axes."""
N_DEMANDS = 2000
"""Demands a share is counted on: its 95 % interval is at most 4.4 points wide."""


CORNERS = 1024
"""Most wrenches of thrusters at their limits that are gone through: those of ten that don't turn."""


def limit_wrenches(vehicle: Vehicle) -> FloatArray:
    """Wrenches (M, k) of thrusters that all stand at a limit, or a polygon's corner.

    Each corner of the attainable set is one.

    Empty where they are more than CORNERS.
    """
    pushed = (vehicle.TP[:, parts].any() for parts in map(list, vehicle.actuators))
    each = [at if moves else at[:1] for at, moves in zip(vertices(vehicle), pushed, strict=True)]
    if prod(map(len, each)) > CORNERS:
        return np.zeros((0, vehicle.k))
    thrusts = np.array([np.concatenate(chosen) for chosen in product(*each)])
    wrenches: FloatArray = thrusts @ vehicle.TP.T
    return wrenches


class CapabilityQuestions(NamedTuple):
    """Questions to the methods about one vehicle.

    Attributes
    ----------
    states : no fault and the worst one, each with demands uniform in volume on the vehicle that has it
    plain : the same, each with no demand at all and demands on one and two axes: they are what a vehicle
        is asked most, and none is drawn by chance. Answers are checked and not counted
    growing : demands of growing size on the whole vehicle
    corners : ``limit_wrenches`` of the whole vehicle; None where there are none
    """

    states: list[tuple[int | None, Question]]
    plain: list[tuple[int | None, Question]]
    growing: Case
    corners: Case | None

    @property
    def cases(self) -> list[Case]:
        """The cases of the states, those that are checked only, then the growing one and the corners."""
        sets = [question.demands for _, question in (*self.states, *self.plain)]
        last = [self.growing] if self.corners is None else [self.growing, self.corners]
        return [*(Case(demands.vehicle, demands.taus) for demands in sets), *last]


def measure_capabilities(
    vehicles: Sequence[Vehicle], methods: Sequence[str], seed: int, ask: Ask, n: int = N_DEMANDS
) -> list[Capability]:
    """The capability of each vehicle, reproducible from the seed; about a second a vehicle.

    A vehicle whose thrusters have no choice at all (NotApplicable) is left out.
    """
    made: list[tuple[Capability, CapabilityQuestions]] = []
    for vehicle in vehicles:
        try:
            capability, asked = _without_methods(vehicle, seed), _asked(vehicle, seed, n)
        except NotApplicable:
            continue
        taus = asked.states[0][1].demands.taus
        capability.failure_costs += announced_costs(vehicle, taus)
        capability.mixer = mixer_cost(vehicle, taus)
        made.append((capability, asked))
    if not made:
        return []
    for method in methods:
        answers = iter(ask(method, [case for _, asked in made for case in asked.cases]))
        for capability, asked in made:
            _add(capability, method, asked, [next(answers) for _ in asked.cases])
    for capability, _ in made:
        capability.served.sort(key=lambda served: served.fault is not None)  # the whole vehicle first
    return [capability for capability, _ in made]


def even_demands(vehicle: Vehicle, seed: int, n: int = N_DEMANDS) -> FloatArray:
    """Demands (n, k) drawn evenly from what a vehicle can do [N, N m]."""
    drawn = uniform_demands(strong_vehicle(vehicle), np.random.default_rng(seed), n)
    return unasked_weak_axes(vehicle, drawn)


def _asked(vehicle: Vehicle, seed: int, n: int) -> CapabilityQuestions:
    states: dict[int | None, Vehicle] = {None: vehicle}
    if len(vehicle.ready) > 1:
        worst = worst_fault(strong_vehicle(vehicle))
        states[worst] = vehicle.with_fault(worst)
    sets = [
        labelled(
            "demands drawn evenly",
            state,
            even_demands(state, seed, n),
        )
        for state in states.values()
    ]
    plain = [labelled("on one axis or two", state, along_axes(state, AXES)) for state in states.values()]
    ends = unasked_weak_axes(vehicle, limit_wrenches(strong_vehicle(vehicle)))
    # What is wrong is found without an optimum, so no reference is asked.
    asked = questions([*sets, *plain], lambda _, cases: [Unanswered("missing", "")] * len(cases))
    return CapabilityQuestions(
        list(zip(states, asked[: len(states)], strict=True)),
        list(zip(states, asked[len(states) :], strict=True)),
        Case(vehicle, demands_of_growing_size(vehicle, np.random.default_rng(seed))),
        Case(vehicle, ends) if len(ends) else None,
    )


def _without_methods(vehicle: Vehicle, seed: int) -> Capability:
    return Capability(
        vehicle=vehicle.name,
        dof=list(vehicle.dof),
        authority=remaining_authority(vehicle),
        served=[],
        curves=[],
        planes=planes(vehicle, seed),
        names=list(vehicle.names),
        last_metre=last_metre(vehicle, seed),
        weak_costs=axis_costs(vehicle),
        fuse=fuse_cost(vehicle, seed),
    )


def _add(
    capability: Capability, method: str, asked: CapabilityQuestions, answers: list[Answers | Unanswered]
) -> None:
    """Add what a method answered to a vehicle's cases; a method that refuses the vehicle adds nothing."""
    vehicles = [case.vehicle for case in asked.cases]
    for vehicle, answer in zip(vehicles, answers, strict=True):
        if isinstance(answer, Unanswered) and answer.status != "refused":
            off = "".join(f"with {vehicle.called(i)} off: " for i, _ in vehicle.faults)
            reason = f"{off}{answer.reason}"
            capability.unserved.append(Unserved(method=method, status=answer.status, reason=reason))
            return
    of_corners = answers.pop() if asked.corners else None
    *of_states, of_growing = answers
    for (fault, question), answer in zip((*asked.states, *asked.plain), of_states, strict=True):
        if isinstance(answer, Answers) and (wrong := _wrong(question, answer)):
            off = "" if fault is None else f" with {question.demands.vehicle.called(fault)} off"
            capability.wrong.setdefault(method, f"{question.demands.name}{off}: {wrong}")
    for (fault, question), answer in zip(asked.states, of_states[: len(asked.states)], strict=True):
        if isinstance(answer, Answers):
            vehicle, taus = question.demands.vehicle, question.demands.taus
            error = strong_error(vehicle, taus, answer.F)
            corners = None
            if fault is None:
                capability.failure_costs += failure_costs(vehicle, method, taus, answer.F)
            if fault is None and asked.corners and isinstance(of_corners, Answers):
                corners = worst_loss(vehicle, asked.corners.taus, of_corners.F)
            capability.served.append(
                Served(
                    fault=fault,
                    method=method,
                    n_demands=len(taus),
                    within_1pct=int(np.count_nonzero(error <= SERVED_WITHIN)),
                    within_5pct=int(np.count_nonzero(error <= 0.05)),
                    sample=worst_loss(vehicle, taus, answer.F),
                    corners=corners,
                    missed=b"" if fault is not None else np.packbits(~(error <= SERVED_WITHIN)).tobytes(),
                )
            )
    if isinstance(of_growing, Answers):
        capability.curves.append(error_curve(method, asked.growing, of_growing.F))


def _wrong(question: Question, answer: Answers) -> str:
    """Errors of answers by the equations, in words; empty for none, or where nothing is promised."""
    if not answer.promises:
        return ""
    # A wrong plug-in's status may be any number, which is for the judge to say.
    pairs = zip(np.ascontiguousarray(answer.F), cast("list[Status]", answer.status.tolist()), strict=True)
    given = [Allocation(f, status) for f, status in pairs]
    return judge(question, given, **answer.promises, thorough=False).wrong


def remaining_authority(vehicle: Vehicle) -> list[Authority]:
    """Authority of the vehicle: whole first, then with each working thruster off; of the strong part each."""
    faults = vehicle.ready if len(vehicle.ready) > 1 else ()
    states: dict[int | None, Vehicle] = {None: vehicle, **{i: vehicle.with_fault(i) for i in faults}}
    # With rows in the same units for all states, volumes can be compared.
    weak = any(state.weak_left.any() for state in states.values())
    seen = {fault: state.strong if weak else state for fault, state in states.items()}
    volume = attainable_volume(seen[None])
    return [_authority(states[fault], part, fault, seen[None].rank, volume) for fault, part in seen.items()]


def _authority(
    vehicle: Vehicle, strong: Vehicle, fault: int | None, whole_rank: int, whole_volume: float
) -> Authority:
    volume = attainable_volume(strong)
    sigma = np.linalg.svd(strong.TP / strong.row_lengths[:, None], compute_uv=False)
    axes = strong_demands(vehicle, np.eye(vehicle.k))
    kept = strong.rank == whole_rank
    return Authority(
        fault=fault,
        vehicle=vehicle.name,
        rank=strong.rank,
        condition=float(sigma[0] / sigma[whole_rank - 1]) if kept else None,
        volume_share=volume / whole_volume if kept and whole_volume else 0.0,
        closed_form_share=_closed_form_share(strong, volume),
        safe_share=safe_share(strong),
        axis_min=_finite(-alpha_max(strong, -axes)),
        axis_max=_finite(alpha_max(strong, axes)),
    )


def _closed_form_share(vehicle: Vehicle, volume: float) -> float | None:
    try:
        return closed_form_volume(vehicle) / volume if volume else None
    except SolverError:
        return None


def _finite(values: FloatArray) -> list[float | None]:
    return [value if isfinite(value) else None for value in values.tolist()]  # JSON has no infinity
