"""A vehicle file checked: its remarks with their lines, and the facts that follow."""

from pathlib import Path
from typing import get_args

from alloc.errors import FileError, VehicleError
from alloc.lint import remarks
from alloc.lint.esc import on_esc
from alloc.lint.failures import Failure, failures
from alloc.lint.report import Facts, Finding, Level, Report
from alloc.vehicle.condition import condition
from alloc.vehicle.file import matrices, vehicle_with
from alloc.vehicle.read import find_file, read_document


def check_vehicle(name: str | Path) -> Report:
    """Check a vehicle file as far as it can be understood; raises UnknownName where there is none."""
    path = find_file(name)
    try:
        document = read_document(path)
    except (FileError, VehicleError) as error:
        key = error.key if isinstance(error, VehicleError) else ""
        return Report(path, None, (Finding("error", key, error.line, error.what),))
    keys, lines = document.keys, document.tree.lines
    collected = list(remarks.on_name(keys, path))
    facts = None
    lost: tuple[Failure, ...] = ()
    try:
        T, computed = matrices(keys)
        collected += remarks.on_poses(keys, set(lines), T, computed)
        collected += remarks.on_mirror_images(keys)
        vehicle = vehicle_with(keys, T)
        collected += remarks.on_columns(keys, T)
        collected += remarks.on_reach(keys, vehicle)
        collected += remarks.on_digits(keys, vehicle)
        collected += remarks.on_limits(vehicle)
        collected += remarks.on_units(vehicle)
        collected += remarks.on_moving_limits(keys, vehicle)
        collected += on_esc(keys, vehicle)
        collected += remarks.on_weights(vehicle)
        lost = tuple(failures(vehicle))
        collected += remarks.on_failures(lost, condition(vehicle))
        steps, remarked = remarks.on_exact_method(vehicle)
        collected += remarked
        facts = Facts(
            name=vehicle.name,
            k=vehicle.k,
            n=vehicle.n,
            rank=vehicle.rank,
            nullity=vehicle.nullity,
            condition=condition(vehicle),
            worst_case_steps=steps,
            frame=vehicle.frame,
        )
    except VehicleError as error:
        collected.append(("error", error.key, error.what))
    findings = [
        Finding(level, key, lines.get(key) if key else None, message) for level, key, message in collected
    ]
    findings.sort(key=lambda finding: get_args(Level).index(finding.level))
    return Report(path, facts, tuple(dict.fromkeys(findings)), lost)
