"""CSV of T: one row a DOF, one column a thruster; a header and a first column of DOF names may be there.

A comment ``# frame: flu`` says the frame.
"""

from pathlib import Path

from alloc import Vehicle
from alloc.errors import VehicleError
from alloc.files.textfile import read_text
from alloc.vehicle import LARGEST
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import VehicleFile
from bench.inputs.csv_text import csv_text
from bench.inputs.delimited import numeric, read_table
from bench.inputs.draft import Draft, commented
from bench.inputs.frames import frame_comment

HELD = frozenset({"dof", "frame", "T", "planar", "thrusters", "center_of_mass", "reaction_torque"})
"""Keys of a vehicle file that the format holds, or makes T of."""


def recognises(path: Path, text: str) -> bool:
    """Whether the file is named .csv."""
    return path.suffix.lower() == ".csv"


def read(path: Path) -> Draft:
    """The Draft of a CSV file; raises FileError naming file and line, or VehicleError."""
    cells = read_table(path)
    table = [(line, [cell.strip() for cell in row]) for line, row in cells.rows]
    if any(map(numeric, cells.header)):  # what looks like a header is the first row
        table.insert(0, (cells.line, cells.header))
    named = any(row[0].lower() in DOF for _, row in table)
    if not table:
        raise VehicleError(f"{path}: holds no rows; give one row of T a DOF")
    widths = {len(row) for _, row in table}
    if len(widths) != 1:
        raise VehicleError(f"{path}: rows differ in length; give one cell a thruster in every row")
    dof = tuple(row[0].lower() for _, row in table) if named else ()
    T = [
        [cells.number(line, f"column {j + 1}", cell, LARGEST) for j, cell in enumerate(row) if j or not named]
        for line, row in table
    ]
    draft = Draft(source=f"{path.name}, CSV of T", dof=dof, T=T)
    return commented(draft, read_text(path))


def write(keys: VehicleFile, vehicle: Vehicle) -> str:
    """T as CSV with a first column of DOF names; limits and weights have no place in this format."""
    header = ["dof", *(f"f{i}" for i in range(vehicle.n))]
    rows = ([axis, *row] for axis, row in zip(vehicle.dof, vehicle.T.tolist(), strict=True))
    return frame_comment(vehicle.frame) + csv_text(header, rows)
