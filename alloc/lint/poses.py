"""The remarks on a vehicle's name and poses: what its file contradicts, what looks like a slip."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from alloc.allocation import FloatArray
from alloc.lint.report import FARTHEST_ARM, Remark, error, note, warning
from alloc.vehicle.file import called, find_file, list_vehicles
from alloc.vehicle.geometry import contradictions
from alloc.vehicle.keys import VehicleFile


def on_name(keys: VehicleFile, path: Path) -> Iterator[Remark]:
    """A remark on a file that has the name of a shipped vehicle, and is another file."""
    if keys.name in list_vehicles() and not path.samefile(find_file(keys.name)):
        yield note("name", f"{keys.name} is a shipped vehicle, too; with another name tables tell them apart")


def on_poses(
    keys: VehicleFile, present: set[str], T: FloatArray, computed: FloatArray | None
) -> Iterator[Remark]:
    """Remarks on frame and poses, and on T (k, n) against the T ``computed`` from the poses.

    ``present`` holds the keys that stand in the file.
    """
    if computed is not None:
        for contradiction in contradictions(T, computed, keys.dof, called(keys, T.shape[1])):
            yield error("T", f"{contradiction}; correct the one that is wrong, or leave it out")
    if "frame" not in present:
        yield note("frame", "no 'frame' given; x forward, y starboard, z down (frd) is taken for granted")
    if keys.thrusters is None:
        if "center_of_mass" in present:
            yield warning("center_of_mass", "has no effect without thrusters; put it into T, or leave it out")
        return
    positions = np.array([thruster.position for thruster in keys.thrusters])
    middle = positions.mean(axis=0)
    reach = np.linalg.norm(positions - middle, axis=1).max()
    if "center_of_mass" not in present:
        yield note("center_of_mass", "not given; moments are taken about the origin of the positions")
    elif np.linalg.norm(np.array(keys.center_of_mass) - middle) > reach:
        yield warning("center_of_mass", "lies outside the thrusters; check its unit (m) and its origin")
    if np.abs(positions).max() > FARTHEST_ARM:
        yield warning("thrusters", f"a position is over {FARTHEST_ARM:g} m off; mm? divide by 1000")
    names = called(keys, len(keys.thrusters))
    for i, thruster in enumerate(keys.thrusters):
        for j, other in enumerate(keys.thrusters[:i]):
            if (other.position, other.direction) == (thruster.position, thruster.direction):
                yield warning(
                    f"thrusters[{i}]", f"{names[i]} has the same position and direction as {names[j]}"
                )
                break


def on_mirror_images(keys: VehicleFile) -> Iterator[Remark]:
    """A remark on each pair, port and starboard, that points against its mirror image where others don't.

    Pairs that push straight to a side say nothing: people have them point the same way or apart.
    """
    if keys.thrusters is None:
        return
    positions = np.array([thruster.position for thruster in keys.thrusters])
    directions = np.array([thruster.direction for thruster in keys.thrusters])
    mirror = np.array([1.0, -1.0, 1.0])
    middle = np.array([0.0, keys.center_of_mass[1], 0.0])
    near = 0.02 * np.ptp(positions, axis=0).max() + 1e-9
    alike, against = [], []
    for i in range(len(positions)):
        image = (positions[i] - middle) * mirror + middle
        for j in np.flatnonzero(np.linalg.norm(positions - image, axis=1) <= near).tolist():
            if j <= i or np.abs(directions[i] * mirror).dot([1.0, 0.0, 1.0]) < 0.05:
                continue
            if np.allclose(directions[j], directions[i] * mirror, atol=0.02):
                alike.append((i, j))
            elif np.allclose(directions[j], -directions[i] * mirror, atol=0.02):
                against.append((i, j))
    if len(alike) > len(against):
        for i, j in against:
            a, b = (keys.thrusters[at].name or f"thruster {at}" for at in (i, j))
            yield warning(
                f"thrusters[{j}]",
                f"{a} and {b} are mirror images that push opposite ways, unlike {len(alike)} other"
                f" {'pair' if len(alike) == 1 else 'pairs'}; is one reversed?",
            )
