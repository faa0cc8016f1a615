"""Poses of thrusters: those of a file, and those that its T allows."""

from pathlib import Path

import numpy as np
import pytest

from alloc import list_vehicles
from alloc.vehicle.file import find_file, matrices, poses, read_document, suspects
from alloc.vehicle.geometry import DOF, pose_matrix
from tests.places import DOCS

FILES = [find_file(name) for name in list_vehicles()] + [DOCS / "vehicles" / "box8.yaml"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_poses_make_the_t_that_they_come_from(path: Path) -> None:
    """T of the poses about the centre of mass is the file's own; published matrices have three digits."""
    keys = read_document(path).keys
    T, _ = matrices(keys)
    positions, directions, center, measured, stands = poses(keys, T)
    assert {*np.flatnonzero(~stands).tolist()} == suspects(keys, len(stands))
    assert measured == (keys.T is None or keys.thrusters is not None)
    made = pose_matrix(positions, directions, center)[[DOF.index(axis) for axis in keys.dof]]
    kept = [axis in ("surge", "sway", "heave", "yaw") for axis in keys.dof]
    largest = np.abs(T).max(axis=1)
    off = (np.abs(made - T) * stands).max(axis=1) / largest
    assert (off[kept] < 0.02).all()
    if keys.T is None:
        assert (off < 1e-9).all()
