"""The gate's cells: the default ones, the chosen ones, and how a fresh process is made ready to run them."""

import fnmatch
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from glob import escape
from typing import Any

import numpy as np

from alloc.errors import UnknownName
from bench.gate.record import CONTROL, GateCell
from bench.gate.side import Side

VEHICLES = ("ukwial", "bluerov2-heavy")

METHODS = (
    *("pinv", "svd", "walsh", "nullspace", "nullspace@native"),
    *("clip", "shrink", "redistribute", "qp/daqp:reused", "qp/piqp:reused"),
)
DEFAULT_CELLS = tuple(f"{vehicle}:{method}" for vehicle in VEHICLES for method in METHODS)
"""Closed forms, the exact method, practical rules and QP paths, on four thrusters and on eight."""

NEAR = 8
"""Most cells that a refusal names."""

Demands = Mapping[str, list[list[float]]]
"""By vehicle, the demands (N, k) [N, N m] that its cells are timed with."""

CONTROL_DEMANDS: list[list[float]] = np.linspace(-1.0, 1.0, 180).reshape(30, 6).tolist()


def chosen(cells: Sequence[Sequence[str]], patterns: Sequence[str]) -> list[GateCell]:
    """The cells whose name ``vehicle:method:start`` fits a shell pattern; the start may be left out."""
    all_cells = [GateCell(vehicle=vehicle, method=method, start=start) for vehicle, method, start in cells]
    return [
        cell
        for cell in all_cells
        if any(
            fnmatch.fnmatchcase(cell.name, p) or fnmatch.fnmatchcase(cell.name, f"{p}:*") for p in patterns
        )
    ]


def unmatched(cells: Sequence[Sequence[str]], pattern: str) -> str:
    """The refusal of a pattern that fits no cell, with cells of its method, else like it, or all."""
    vehicle, method, *_ = *pattern.split(":"), ""
    names = list(dict.fromkeys(cell.name for cell in chosen(cells, ["*"])))
    of_method = [f"{vehicle}:{method or '*'}", f"*:{method or vehicle}"]
    fitting = ([cell.name for cell in chosen(cells, [asked])] for asked in of_method)
    close = get_close_matches(pattern, names, n=3, cutoff=0.8)
    of_vehicle = [cell.name for cell in chosen(cells, [f"{vehicle}:*"])]
    near = list(dict.fromkeys(next(filter(None, (*fitting, close, of_vehicle, names)), ["none"])))
    more = f" and {len(near) - NEAR} more" if len(near) > NEAR else ""
    return f"no cell of either side fits {pattern}; there are {', '.join(near[:NEAR])}{more}"


def among(vehicles: Sequence[str], patterns: Sequence[str]) -> list[str]:
    """The patterns, for cells of these vehicles alone; raises UnknownName for one that is for another."""
    found = []
    for pattern in patterns:
        vehicle, _, rest = pattern.partition(":")
        fitting = [name for name in vehicles if fnmatch.fnmatchcase(name, vehicle)]
        if not fitting:
            named = " --vehicle ".join(vehicles)
            raise UnknownName(
                f"--cells {pattern}: is for none of --vehicle {named}; leave one of the two out, or write"
                " '*:METHOD'"
            )
        found += [f"{escape(name)}:{rest or '*'}" for name in fitting]
    return found


def controls() -> list[GateCell]:
    """The cells that no commit can change: a numpy product and a loop in Python."""
    return [GateCell(vehicle=CONTROL, method=method) for method in ("product", "loop")]


def load(side: Side, cells: Sequence[GateCell], demands: Demands, core: int | None) -> None:
    """Build the cells in a fresh process, hand over their demands, and pin the process to a core."""
    for cell in cells:
        if cell.is_control:
            side.ask("control", cell=cell.name, kind=cell.method)
        else:
            side.ask("build", cell=cell.name, **names(cell))
    for vehicle in {cell.vehicle: None for cell in cells}:
        side.ask("keep", vehicle=vehicle, taus=demands[vehicle])
    side.ask("settle", core=core)


def names(cell: GateCell) -> dict[str, Any]:
    """Names by which a worker builds the cell."""
    return {"vehicle": cell.vehicle, "method": cell.method, "start": cell.start}
