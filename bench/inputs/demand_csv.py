"""Reads demands from CSV and writes thrusts as CSV, for users' scripts."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from alloc import Allocation, DemandError, FloatArray, Status
from alloc.files.textfile import read_text
from bench.inputs.csv_text import csv_rows, csv_text, is_number, number


def read_demands(path: Path, dof: tuple[str, ...]) -> tuple[FloatArray | None, FloatArray]:
    """Demands from a CSV file whose header names the DOF, in any order, and maybe the time.

    Parameters
    ----------
    path : the file: one row a demand; a byte order mark, CRLF and blank lines are accepted
    dof : the vehicle's controlled DOF; each needs a column, and only ``t`` may have one besides

    Returns
    -------
    t : (N,) the column ``t`` [s], never decreasing; None where there is no such column
    taus : (N, k) columns in the order of ``dof`` [N, N m]

    Raises
    ------
    FileError where the file is no CSV of numbers, DemandError where the numbers are no demands of this
    vehicle; both name file, line, column and remedy.
    """
    rows = csv_rows(path, read_text(path))
    line, header = next(rows, (1, []))
    columns = [name.strip() for name in header]
    _check_header(f"{path}: line {line}", columns, dof)
    table: list[list[float]] = []
    for line, row in rows:
        if len(row) != len(columns):
            raise DemandError(
                f"{path}: line {line}: {len(row)} cells under {len(columns)} columns; give one a column"
            )
        table.append([number(path, line, name, cell) for name, cell in zip(columns, row, strict=True)])
    if not table:
        raise DemandError(f"{path}: holds no demands; give one row a demand below the header")
    values = np.array(table)
    taus = values[:, [columns.index(axis) for axis in dof]]
    if "t" not in columns:
        return None, taus
    t = values[:, columns.index("t")]
    back = np.flatnonzero(np.diff(t) < 0)
    if back.size:
        raise DemandError(
            f"{path}: t goes back from {t[back[0]]:g} to {t[back[0] + 1]:g} s; put rows in time order"
        )
    return t, taus


def format_demands(t: FloatArray | None, taus: FloatArray, dof: tuple[str, ...]) -> str:
    """The CSV of times (N,) [s] or None and demands (N, k), in the form that ``read_demands`` reads."""
    if t is None:
        return csv_text(dof, taus.tolist())
    return csv_text(("t", *dof), np.column_stack([t, taus]).tolist())


def parse_scale(text: str, dof: tuple[str, ...]) -> FloatArray:
    """Factors (k,) from ``"200"``, one for all DOF, or ``"200,200,50"``, one each; raises DemandError."""
    cells = text.split(",") if text else ["1"]
    if not all(map(is_number, cells)) or len(cells) not in (1, len(dof)):
        raise DemandError(f"--scale {text!r}: give one number, or one for each of {', '.join(dof)}")
    return np.broadcast_to(np.array([float(cell) for cell in cells]), (len(dof),))


def format_thrusts(answers: Sequence[Allocation]) -> str:
    """The CSV of answers, a row each: status, thrusts [N] (``nan`` where there are none), shares if any."""
    first = answers[0]
    header = [
        "status",
        *(f"f{i}" for i in range(len(first.f))),
        *(f"share{i}" for i in range(len(first.share))),
    ]
    return csv_text(header, ([Status(a.status).name, *a.f.tolist(), *a.share] for a in answers))


def _check_header(place: str, columns: list[str], dof: tuple[str, ...]) -> None:
    wanted = ",".join(dof)
    if not columns:
        raise DemandError(f"{place}: the file is empty; give a header '{wanted}' and one row a demand")
    if len(columns) == 1 and re.search("[;\t]", columns[0]):
        raise DemandError(
            f"{place}: cells are separated by semicolons or tabs; use commas and '.' in numbers"
        )
    for name in columns:
        if columns.count(name) > 1:
            raise DemandError(f"{place}: column {name[:40]!r} appears twice; keep one")
        if name not in dof and name != "t":
            raise DemandError(f"{place}: unknown column {name[:40]!r}; the header takes {wanted} and maybe t")
    missing = [axis for axis in dof if axis not in columns]
    if missing:
        raise DemandError(f"{place}: no column {missing[0]!r}; the header takes {wanted} and maybe t")
