"""CSV with a column of commands for each thruster, as ``thrustbench allocate --esc`` writes them."""

import itertools
from pathlib import Path

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from bench.inputs.delimited import read_table
from bench.inputs.outputs import Outputs

SUFFIXES = (".csv", "")
LARGEST = 1e20
"""Bound on every number, times in ns among them."""


def read(path: Path, vehicle: Vehicle) -> Outputs:
    """Columns ``u0``, ``u1``, … and, where there are such, ``t`` [s], ``volts`` and the names of the DOF."""
    table = read_table(path)
    names = [f"u{i}" for i in range(vehicle.n)]
    missing = [name for name in names if table.header.count(name) != 1]
    if missing:
        raise DemandError(
            f"{path}: line {table.line}: no one column {missing[0]!r}; give u0 … u{vehicle.n - 1}, the"
            " command of each thruster"
        )
    further = [name for name in ("t", "volts") if name in table.header]
    axes = list(vehicle.dof) if set(vehicle.dof) <= set(table.header) else []
    wanted = [*names, *further, *axes]
    places = [table.header.index(name) for name in wanted]
    rows = []
    for line, cells in table.rows:
        if len(cells) < len(table.header):
            raise table.refused(line, f"has {len(cells)} cells of {len(table.header)}; mend that row")
        rows.append(
            [table.number(line, name, cells[at], LARGEST) for name, at in zip(wanted, places, strict=True)]
        )
    values = np.array(rows).reshape(len(rows), len(wanted))
    column: dict[str, FloatArray] = dict(zip(wanted, values.T, strict=True))
    if "t" in column and any(later < earlier for earlier, later in itertools.pairwise(column["t"])):
        raise DemandError(f"{path}: times in 't' go back; sort the rows")
    taus = np.column_stack([column[axis] for axis in axes]) if axes else None
    said = f"{path.name}: {names[0]} … {names[-1]} are the commands"
    return Outputs(column.get("t"), values[:, : vehicle.n], column.get("volts"), taus, said=said)
