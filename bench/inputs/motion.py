"""Accelerations and velocities beside the outputs in a log, for readiness."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from bench.inputs.demand_csv import read_demands
from bench.inputs.outputs import Outputs
from bench.inputs.table import TABLES, read_table

FORM = "m/s^2, rad/s^2, m/s, rad/s, in the vehicle's frame, without gravity"


class Motion(NamedTuple):
    """Motion of a vehicle at the rows of its outputs, in its own frame.

    Attributes
    ----------
    t : (N,) times [s]
    a : (N, k) rates of change of v [m/s^2, rad/s^2]
    v : (N, k) velocities [m/s, rad/s]
    """

    t: FloatArray
    a: FloatArray
    v: FloatArray


def read_motion(
    path: Path, outputs: Outputs, vehicle: Vehicle, columns: Mapping[str, str] | None = None
) -> Motion:
    """Columns ``a_surge`` … and ``v_surge`` …, one a DOF, of the table that the outputs were read from.

    Raises DemandError where the log is no table, lacks a column, a number or times.
    """
    names = [f"{letter}_{axis}" for letter in "av" for axis in vehicle.dof]
    needed = f"--accelerations needs {', '.join(names)} [{FORM}]"
    if path.is_dir() or path.suffix.lower() not in TABLES:
        raise DemandError(f"{path}: accelerations are read of tables only; {needed}, beside t and u0, u1, …")
    header = read_table(path).header
    missing = [name for name in names if name not in header]
    if missing:
        raise DemandError(f"{path}: no column {missing[0]!r}; {needed}")
    if outputs.t is None:
        raise DemandError(f"{path}: no column 't'; --accelerations needs times [s]")
    log = read_demands(path, vehicle.dof, columns, commands=names)
    assert log.u is not None
    if len(log.u) != len(outputs.u) or not np.isfinite(log.u).all():
        raise DemandError(f"{path}: some rows have commands and no motion, or no number; cut them out")
    return Motion(outputs.t, log.u[:, : vehicle.k], log.u[:, vehicle.k :])
