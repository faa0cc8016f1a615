"""CSV of T: one row a DOF, one column a thruster; a header and a first column of DOF names may be there.

A comment ``# frame: flu`` says the frame.
"""

from pathlib import Path

from alloc import Vehicle
from alloc.errors import VehicleError
from alloc.vehicle import LARGEST
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import VehicleFile
from bench.inputs.columns import find_spellings, listed
from bench.inputs.demand_csv import csv_text
from bench.inputs.draft import Draft
from bench.inputs.frames import frame_comment
from bench.inputs.table import Cells, is_numeric, read_table

HELD = frozenset({"dof", "frame", "T", "planar", "thrusters", "center_of_mass", "reaction_torque"})
"""Keys of a vehicle file that the format holds, or makes T of."""

INDEX = ("", "dof", "axis", "row", "index", "name")
"""First cells of a header whose first column has the names of rows."""


def recognises(path: Path, text: str) -> bool:
    """True if the file is named .csv."""
    return path.suffix.lower() == ".csv"


def read(path: Path) -> Draft:
    """The Draft of a CSV file; raises FileError naming file and line, or VehicleError."""
    cells = read_table(path)
    table = [(line, [cell.strip() for cell in row]) for line, row in cells.rows]
    if cells.units:
        raise cells.error(cells.line + 1, "says units; a row of T has none but m, so leave the line out")
    firsts = [row[0].lower() for row in (cells.header, *(row for _, row in table)) if row]
    named = any(first in DOF for first in firsts) or any(first in INDEX for first in firsts[:1])
    headed = _is_header(cells, named)
    if not headed:
        table.insert(0, (cells.line, cells.header))
    if not table:
        raise VehicleError(f"{path}: holds no rows; give one row of T a DOF")
    widths = {len(row) for _, row in table} | ({len(cells.header)} if headed else set())
    if len(widths) != 1:
        raise VehicleError(f"{path}: rows differ in length; give one cell a thruster in every row")
    dof = _names(cells, [(line, row[0]) for line, row in table]) if named else ()
    T = [
        [cells.number(line, f"column {j + 1}", cell, LARGEST) for j, cell in enumerate(row) if j or not named]
        for line, row in table
    ]
    called = cells.header[1 if named else 0 :] if headed else []
    counts = all(map(is_numeric, called)) or called == [f"f{i}" for i in range(len(called))]
    return Draft(source=f"{path.name}, CSV of T", dof=dof, T=T, names=None if counts else called)


def _is_header(cells: Cells, named: bool) -> bool:
    """True if the first line names the columns, or numbers them beside ``named`` rows; raises FileError."""
    header = cells.header
    if not any(map(is_numeric, header)):
        if axes := [cell for cell in header if cell.lower() in DOF] or _axes(header):
            raise cells.error(cells.line, f"{axes[0]} stands in the header; give a row to each DOF")
        return True
    if not named and header in ([str(i + start) for i in range(len(header))] for start in (0, 1)):
        raise cells.error(
            cells.line, f"{listed(header)} may be a header or a row; name the rows, as in surge,0.5,1"
        )
    return header[0].lower() in INDEX


def _axes(header: list[str]) -> list[str]:
    """The cells of a header each of which says another DOF, as Fx, Fy, Mz or X, Y, N; else none."""
    cells = header[1:] if header[:1] and header[0].lower() in INDEX else header
    letters = {cell.upper() for cell in cells} <= set("XYZKMN")
    return cells if cells and (letters or find_spellings(cells)) else []


def _names(cells: Cells, firsts: list[tuple[int, str]]) -> tuple[str, ...]:
    """The DOF of each row, by its first cell and line; raises FileError for one that is none, or twice."""
    dof: list[str] = []
    for line, name in firsts:
        if name.lower() not in DOF:
            raise cells.error(line, f"{name[:40]!r} is no DOF; begin the row with one of {', '.join(DOF)}")
        if name.lower() in dof:
            raise cells.error(line, f"{name} stands twice; keep one of its rows")
        dof.append(name.lower())
    return tuple(dof)


def write(keys: VehicleFile, vehicle: Vehicle) -> str:
    """T as CSV with a first column of DOF names; limits and weights have no place in this format."""
    header = ["dof", *(f"f{i}" for i in range(vehicle.n))]
    rows = ([axis, *row] for axis, row in zip(vehicle.dof, vehicle.T.tolist(), strict=True))
    return frame_comment(vehicle.frame) + csv_text(header, rows)
