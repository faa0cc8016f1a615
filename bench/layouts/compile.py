"""Compile a study file into its base vehicle and the space of its layouts."""

import re
from dataclasses import dataclass
from math import comb
from pathlib import Path

import numpy as np

from alloc import AllocError, Vehicle, list_vehicles
from alloc.allocation import FloatArray
from alloc.errors import DemandError, FileError, UnknownName, VehicleError, unknown
from alloc.vehicle.file import Mounting, find_file, matrices, poses, read_document, vehicle_with
from alloc.vehicle.geometry import DOF, pose_matrix
from alloc.vehicle.keys import VehicleFile
from bench.demands import DemandSet, build_demands
from bench.inputs.columns import parse_columns
from bench.inputs.logs import LogOptions
from bench.layouts.authority import volumes
from bench.layouts.space import LayoutSpace, Moving, Parameter, Setting, reflections, turns
from bench.layouts.spaces import single_layout, spaces
from bench.layouts.study import Span, StudyDocument, Values, VariedGroup
from bench.results.text import cut_note

LEFT_OUT = ("slack_weights", "slew", "volts", "esc", "priority", "groups")


@dataclass(frozen=True, eq=False)
class Base:
    """A vehicle, and where its thrusters stand, in its frame.

    Attributes
    ----------
    vehicle : T from the poses, in the degrees of freedom that count
    position, direction : (n, 3) [m], [-]
    center : (3,) of mass [m]
    left_out : keys of its file that no layout has: a new thruster has no slew rate, and another size no curve
    """

    vehicle: Vehicle
    position: FloatArray
    direction: FloatArray
    center: FloatArray
    left_out: tuple[str, ...]


def read_base(document: StudyDocument) -> Base:
    """The base that a study names; raises StudyError where it is none to vary."""
    name = document.keys.base
    path = find_file(name) if name in list_vehicles() else document.tree.path.parent / name
    try:
        if name not in list_vehicles() and not path.exists():
            raise unknown("vehicle", name, list_vehicles(), ", or a file beside the study")
        file = read_document(path).keys
        stands = _poses(file)
        position, center = stands.positions, stands.center
        direction = stands.directions / np.linalg.norm(stands.directions, axis=1, keepdims=True)
        dof = tuple(document.keys.dof if document.keys.dof is not None else file.dof)
        if not dof or not set(dof) <= set(DOF) or len(set(dof)) < len(dof):
            raise document.refusal("dof", f"give different names out of {', '.join(DOF)}")
        T = pose_matrix(position, direction, center)[[DOF.index(axis) for axis in dof]]
        vehicle = vehicle_with(_counted(file, dof), T)
        _check(vehicle)
    except (VehicleError, UnknownName, FileError) as error:
        raise document.refusal("base", str(error)) from None
    left_out = tuple(key for key in LEFT_OUT if getattr(file, key))
    return Base(vehicle, position, direction, center, left_out)


def _counted(file: VehicleFile, dof: tuple[str, ...]) -> VehicleFile:
    from msgspec.structs import replace

    kept = None
    if file.slack_weights is not None:
        by_axis: dict[str, float] = dict(zip(file.dof, file.slack_weights, strict=False))
        kept = [by_axis[axis] for axis in dof] if set(dof) <= set(by_axis) else None
    return replace(file, dof=list(dof), slack_weights=kept, rank=None)


def _poses(file: VehicleFile) -> Mounting:
    """Poses of the thrusters; raises VehicleError for a file that has T alone."""
    found = poses(file, matrices(file)[0])
    if file.reaction_torque:
        raise VehicleError(
            f"{file.name} has propellers' own moments, which layouts leave out; study it without them",
            "reaction_torque",
        )
    if not found.measured:
        raise VehicleError(
            f"{file.name} has T, but no poses that could vary; give it 'thrusters' or 'planar' too", "T"
        )
    return found


def _check(vehicle: Vehicle) -> None:
    """Raise VehicleError for a base whose layouts could not be compared."""
    name = vehicle.name
    if vehicle.rank < vehicle.k:
        raise VehicleError(
            f"{name} pushes {vehicle.rank} of {vehicle.k} degrees of freedom alone; name those under 'dof'"
        )
    if (vehicle.f_min > 0).any() or (vehicle.f_max < 0).any() or (vehicle.f_min >= vehicle.f_max).any():
        raise VehicleError(f"{name} has a thruster that can't rest or can't push; give f_min <= 0 <= f_max")
    if np.count_nonzero(vehicle.H - np.diag(np.diag(vehicle.H))):
        raise VehicleError(f"{name} has an H that couples thrusters; layouts take 'weights', one a thruster")


def mean_arm(base: Base) -> float:
    """Root mean square distance of a base's thrusters from its centre of mass; 1 for thrusters at it [m]."""
    arm = float(np.sqrt(((base.position - base.center) ** 2).sum(axis=1).mean()))
    return arm or 1.0


NEAR = 2e-3
"""By how much a thruster may stand off the image of its leader [m], [-]: published poses have three."""

TILES = 5_000
"""Most tiles, and so about as many facets, of a layout: 14 thrusters in 6 DOF have 3,003."""

POSE = ("x", "y", "z", "azimuth_deg", "cant_deg")

_OPTION = re.compile(r"`?--(frame|columns|scale|n)\b`?")
"""Remedies that are named where a log is read, which are keys here."""


def compile_study(document: StudyDocument) -> tuple[LayoutSpace, Vehicle]:
    """The space of a study's layouts, and its base; raises StudyError."""
    base = read_base(document)
    vehicle = base.vehicle
    parameters: list[Parameter] = []
    groups = _groups(document, base, parameters)
    x, y, z = (
        _setting(
            document, f"center_of_mass.{axis}", getattr(document.keys.center_of_mass, axis), at, parameters
        )
        for axis, at in zip("xyz", base.center.tolist(), strict=True)
    )
    if not parameters:
        raise document.refusal("groups", "nothing varies; give a list, or 'from' and 'to', of something")
    _check_number(document, groups, vehicle.k)
    whole = single_layout(vehicle)
    demands = _demands(document, vehicle)
    space = LayoutSpace(
        name=vehicle.name,
        dof=vehicle.dof,
        parameters=tuple(parameters),
        groups=groups,
        center=(x, y, z),
        constraints=document.keys.constraints,
        taus=np.array(demands.taus),
        reference_length=document.keys.reference_length or mean_arm(base),
        volume=float(volumes(whole, spaces(whole)[1]).whole[0]),
        frame=vehicle.frame,
        left_out=base.left_out,
        notes=_demand_lines(demands),
        rate_hz=demands.rate_hz,
    )
    return space, vehicle


def _check_number(document: StudyDocument, groups: tuple[Moving, ...], k: int) -> None:
    """Raise StudyError where layouts may have so many thrusters that their arrays outgrow memory."""
    most = sum(max(group.images) for group in groups)
    if comb(most, k) > TILES:
        raise document.refusal(
            "groups",
            f"up to {most} thrusters in {k} degrees of freedom have {comb(most, k):,} tiles, above {TILES:,}"
            "; take fewer",
        )


def _demands(document: StudyDocument, vehicle: Vehicle) -> DemandSet:
    asked = document.keys.demands
    log = _log_options(document)
    beside = document.tree.path.parent / asked.source
    source: str | Path = beside if Path(asked.source).suffix and beside.exists() else asked.source
    try:
        made = build_demands(source, vehicle, document.keys.seed, asked.n, log)
    except AllocError as error:
        raise document.refusal("demands.set", _as_keys(str(error))) from None
    if not made.given and log != LogOptions():
        raise document.refusal("demands", f"frame, columns and scale are of logs; {made.name} takes none")
    return made


def _log_options(document: StudyDocument) -> LogOptions:
    """Options of the study about a log; raises StudyError."""
    asked = document.keys.demands
    scale = tuple(asked.scale) if isinstance(asked.scale, list) else (asked.scale,)
    if not all(factor > 0 for factor in scale):
        raise document.refusal("demands.scale", "give one number above 0, or a list with one for each DOF")
    try:
        columns = parse_columns(asked.columns)
    except DemandError as error:
        raise document.refusal("demands", _as_keys(str(error))) from None
    return LogOptions(frame=asked.frame or "", columns=columns, scale=scale)


def _demand_lines(demands: DemandSet) -> tuple[str, ...]:
    """Remarks on a log; layouts have no limits of single demands, since those are the base's."""
    lines = [_as_keys(line) for line in demands.notes]
    if demands.f_min is not None or (demands.given and demands.vehicle.by_volts is not None):
        lines.append(
            f"{demands.name}: limits by voltage or of single demands are left out:"
            " layouts keep to f_min, f_max"
        )
    if demands.left_out:
        lines.append(_as_keys(cut_note(demands.name, len(demands.taus), demands.left_out)))
    return tuple(lines)


def _as_keys(line: str) -> str:
    """A line about a log with the study's keys in place of options."""
    return _OPTION.sub(r"\1:", line)


def _groups(document: StudyDocument, base: Base, parameters: list[Parameter]) -> tuple[Moving, ...]:
    """The groups of the file, then a group of its own for each other thruster of the base."""
    found, taken = [], set[int]()
    for name, keys in document.keys.groups.items():
        where = f"groups.{name}"
        if (keys.thrusters is None) == (keys.like is None):
            raise document.refusal(where, "give either 'thrusters' of the base, or 'like' for new ones")
        try:
            named = keys.thrusters if keys.thrusters is not None else [keys.like or 0]
            members = [base.vehicle.index(thruster) for thruster in named]
        except VehicleError as error:
            raise document.refusal(where, error.what) from None
        for i in members:
            if keys.thrusters is not None and i in taken:
                raise document.refusal(
                    f"{where}.thrusters", f"{base.vehicle.called(i)} is named twice; a thruster has one group"
                )
            if keys.thrusters is not None:
                taken.add(i)
        if not members:
            raise document.refusal(f"{where}.thrusters", "is empty; name at least one thruster")
        found.append(_moving(document, base, name, keys, members, parameters))
    still = VariedGroup(thrusters=[])
    rest = (i for i in range(base.vehicle.n) if i not in taken)
    return (*found, *(_moving(document, base, f"thruster {i}", still, [i], parameters) for i in rest))


def _moving(
    document: StudyDocument,
    base: Base,
    name: str,
    keys: VariedGroup,
    members: list[int],
    parameters: list[Parameter],
) -> Moving:
    where, lead, new = f"groups.{name}", members[0], keys.like is not None
    count: Setting = float(len(members))
    if not new:
        if keys.mirror or keys.count is not None:
            raise document.refusal(where, "'mirror' and 'count' make new thrusters; give them with 'like'")
        images, polarity = _images(document, base, name, members)
    else:
        images, polarity, count = _new(document, where, keys, parameters)
    e = base.direction[lead]
    azimuth, cant = np.degrees(np.arctan2(e[1], e[0])), np.degrees(np.arcsin(np.clip(e[2], -1, 1)))
    own = (*base.position[lead].tolist(), float(azimuth), float(cant))
    x, y, z, turned, canted = (
        _setting(document, f"{where}.{key}", getattr(keys, key), at, parameters)
        for key, at in zip(POSE, own, strict=True)
    )
    size = _setting(document, f"{where}.size", keys.size, 1.0, parameters)
    for least in (
        [size] if isinstance(size, float) else [*size.choices, *(() if size.choices else (size.low,))]
    ):
        if not least > 0:
            raise document.refusal(f"{where}.size", f"{least:g} is no size; give factors above 0")
    copied = members if not new else [lead] * max(images)
    f_min, f_max, weights = (
        tuple(side[copied].tolist())
        for side in (base.vehicle.f_min, base.vehicle.f_max, np.diag(base.vehicle.H))
    )
    present = [float(p) for p in keys.present] if isinstance(keys.present, list) else float(keys.present)
    return Moving(
        name=name,
        members=() if new else tuple(members),
        called=() if new else tuple(base.vehicle.names[i] for i in members if base.vehicle.names),
        images=images,
        polarity=polarity,
        pose=(x, y, z, turned, canted),
        size=size,
        present=_setting(document, f"{where}.present", present, 1.0, parameters),
        count=count,
        f_min=f_min,
        f_max=f_max,
        weights=weights,
    )


def _images(
    document: StudyDocument, base: Base, name: str, members: list[int]
) -> tuple[dict[int, FloatArray], dict[int, FloatArray]]:
    """Map of each member to the first: mirrored in planes through the origin, or turned about z."""
    r, e = base.position[members[0]], base.direction[members[0]]
    matrices, signs = [], []
    candidates = [(Q, sign) for sign in (1.0, -1.0) for Q in (*reflections(), *turns(len(members))[1:])]
    for i in members:
        for Q, sign in candidates:
            off = max(np.abs(Q @ r - base.position[i]).max(), np.abs(sign * Q @ e - base.direction[i]).max())
            if off <= NEAR:
                matrices.append(Q)
                signs.append(sign)
                break
        else:
            leader = base.vehicle.called(members[0])
            raise document.refusal(
                f"groups.{name}.thrusters",
                f"{base.vehicle.called(i)} of the base is no mirror image of {leader} in the planes xz, yz,"
                " xy, nor turned from it about the vertical axis; put it in a group of its own",
            )
    return {len(members): np.array(matrices)}, {len(members): np.array(signs)}


def _new(
    document: StudyDocument, where: str, keys: VariedGroup, parameters: list[Parameter]
) -> tuple[dict[int, FloatArray], dict[int, FloatArray], Setting]:
    """The images of new thrusters: mirrored in the planes that are named, or evenly around the z axis."""
    if keys.mirror and keys.count is not None:
        raise document.refusal(where, "give 'mirror' or 'count', not both")
    if keys.count is None:
        matrices = np.array(reflections(tuple(keys.mirror)))
        return {len(matrices): matrices}, {len(matrices): np.ones(len(matrices))}, float(len(matrices))
    counts = keys.count if isinstance(keys.count, list) else [keys.count]
    if not counts or min(counts) < 1:
        raise document.refusal(f"{where}.count", "give numbers of thrusters, 1 or more")
    setting = _setting(document, f"{where}.count", [float(c) for c in counts], 1.0, parameters)
    return {c: np.array(turns(c)) for c in counts}, {c: np.ones(c) for c in counts}, setting


def _setting(
    document: StudyDocument, where: str, given: Values | None, own: float, parameters: list[Parameter]
) -> Setting:
    """A number that stays, or a parameter, which is added to ``parameters``; raises StudyError for none."""
    if given is None:
        return own
    if isinstance(given, (int, float)):
        return float(given)
    name = where.removeprefix("groups.")
    if isinstance(given, Span):
        if not given.low < given.high:
            raise document.refusal(
                where, f"the span from {given.low:g} to {given.high:g} is empty; give 'from' < 'to'"
            )
        if document.keys.sampling == "grid" and not (given.steps or 0) >= 2:
            raise document.refusal(where, "a grid takes 'steps' of a span, 2 or more")
        parameter = Parameter(name, low=given.low, high=given.high, steps=given.steps or 0)
    elif not given:
        raise document.refusal(where, "the list is empty; give at least one value")
    elif len(given) == 1:
        return float(given[0])
    else:
        parameter = Parameter(name, choices=tuple(map(float, given)))
    parameters.append(parameter)
    return parameter
