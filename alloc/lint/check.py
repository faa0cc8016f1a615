"""A vehicle file checked: its remarks with their lines, and the facts that follow."""

import re
from pathlib import Path
from typing import get_args

from alloc.errors import FileError, VehicleError
from alloc.lint import remarks
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
        return Report(path, None, (_unread(path, error),))
    keys, lines = document.keys, document.tree.lines
    collected: list[remarks.Remark] = []
    facts = None
    try:
        T, computed = matrices(keys)
        collected += remarks.on_poses(keys, set(lines), T, computed)
        vehicle = vehicle_with(keys, T)
        collected += remarks.on_reach(keys, vehicle)
        collected += remarks.on_limits(vehicle)
        collected += remarks.on_moving_limits(vehicle)
        collected += remarks.on_weights(vehicle)
        collected += remarks.on_failures(vehicle)
        steps, remark = remarks.on_exact_method(vehicle)
        collected.append(remark)
        facts = Facts(
            name=vehicle.name,
            k=vehicle.k,
            n=vehicle.n,
            rank=vehicle.rank,
            nullity=vehicle.nullity,
            condition=condition(vehicle),
            worst_case_steps=steps,
        )
    except VehicleError as error:
        collected.append(("error", error.key, str(error)))
    findings = [Finding(level, key, lines.get(key), message) for level, key, message in collected]
    findings.sort(key=lambda finding: get_args(Level).index(finding.level))
    return Report(path, facts, tuple(findings))


def _unread(path: Path, error: FileError | VehicleError) -> Finding:
    # The message of a reader starts with the file and mostly with the line.
    text = str(error).removeprefix(f"{path}: ")
    line = re.match(r"line (\d+): ", text)
    key = getattr(error, "key", "")
    return Finding("error", key, int(line[1]) if line else None, text[line.end() :] if line else text)
