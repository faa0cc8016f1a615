"""A vehicle file checked: its remarks with their lines, and the facts that follow."""

from pathlib import Path
from typing import get_args

from alloc.errors import FileError, VehicleError
from alloc.lint.autopilot import choose, on_autopilot
from alloc.lint.esc import on_current, on_esc
from alloc.lint.failures import failures, on_exact_method, on_failures, on_weak, pairs
from alloc.lint.geometry import (
    on_columns,
    on_digits,
    on_mirror_images,
    on_name,
    on_odd_entry,
    on_poses,
    on_reach,
    on_traces,
    on_weights,
)
from alloc.lint.limits import on_limits, on_moving_limits, on_polygons, on_units
from alloc.lint.report import Facts, Failure, Finding, Level, Pairs, Report, error
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import condition
from alloc.vehicle.file import (
    Document,
    build_vehicle,
    find_file,
    matrices,
    poses,
    read_document,
    vehicle_with,
)


def check_vehicle(name: str | Path, autopilot: str = "") -> Report:
    """Check a vehicle file as far as it can be understood, with its ``autopilot`` or that of its key.

    Raises UnknownName where there is no such file, VehicleError and FileError for an autopilot that is none.
    """
    path = find_file(name)
    try:
        document = read_document(path)
    except (FileError, VehicleError) as reason:
        key = reason.key if isinstance(reason, VehicleError) else ""
        if reason.path != path:  # a curve's file, which the vehicle's names
            return Report(path, None, (Finding("error", "esc", None, str(reason)),))
        return Report(path, None, (Finding("error", key, reason.line, reason.what),))
    keys, lines = document.keys, document.tree.lines
    if any(thruster.azimuth for thruster in keys.thrusters or ()):
        return _check_azimuths(path, document)
    if autopilot:
        keys.autopilot = choose(autopilot, keys.autopilot)
    collected = list(on_name(keys, path))
    facts = None
    lost: tuple[Failure, ...] = ()
    both: tuple[Pairs, ...] = ()
    try:
        T, computed = matrices(keys)
        collected += on_poses(keys, set(lines), T, computed)
        collected += on_mirror_images(keys)
        collected += on_odd_entry(keys, T)
        vehicle = vehicle_with(keys, T)
        collected += on_columns(keys, T)
        collected += on_reach(keys, vehicle)
        collected += on_digits(keys, vehicle)
        collected += on_traces(keys, vehicle)
        collected += on_limits(vehicle)
        collected += on_units(vehicle)
        collected += on_moving_limits(keys, vehicle)
        collected += on_esc(keys, vehicle)
        collected += on_current(keys, vehicle)
        collected += on_weights(vehicle)
        collected += on_weak(vehicle)
        collected += on_autopilot(vehicle, poses(keys, T))
        lost, both = tuple(failures(vehicle)), tuple(pairs(vehicle))
        collected += on_failures(lost, condition(vehicle.strong))
        steps, remarked = on_exact_method(vehicle)
        collected += remarked
        facts = _facts(vehicle, steps)
    except VehicleError as reason:
        what = reason.what.removeprefix(reason.key).lstrip(":. ")  # the line begins with the key
        collected.append(error(reason.key, what))
    findings = [
        Finding(level, key, lines.get(key) if key else None, message) for level, key, message in collected
    ]
    findings.sort(key=lambda finding: get_args(Level).index(finding.level))
    return Report(path, facts, tuple(dict.fromkeys(findings)), lost, both)


def _facts(vehicle: Vehicle, steps: int | None) -> Facts:
    return Facts(
        name=vehicle.name,
        k=vehicle.k,
        n=len(vehicle.actuators),
        rank=vehicle.rank,
        nullity=vehicle.nullity,
        condition=condition(vehicle),
        worst_case_steps=steps,
        frame=vehicle.frame,
    )


def _check_azimuths(path: Path, document: Document) -> Report:
    """Report on a file with thrusters that turn: polygons, weak directions and failures, no more yet."""
    lines = document.tree.lines
    try:
        vehicle = build_vehicle(document.keys)
    except VehicleError as reason:
        what = reason.what.removeprefix(reason.key).lstrip(":. ")
        return Report(path, None, (Finding("error", reason.key, lines.get(reason.key), what),))
    lost = tuple(failures(vehicle))
    steps, remarked = on_exact_method(vehicle)
    collected = [
        *on_polygons(vehicle),
        *on_units(vehicle),
        *on_weak(vehicle),
        *on_failures(lost, condition(vehicle.strong)),
        *remarked,
    ]
    findings = tuple(Finding(level, key, lines.get(key), message) for level, key, message in collected)
    return Report(path, _facts(vehicle, steps), findings, lost, tuple(pairs(vehicle)))
