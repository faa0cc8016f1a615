#!/usr/bin/env bash
# ezauv's allocation takes each thruster's moment for 1, however long its arm: yaw is out by the arms' length.
#
# Guess: a library that is told positions, directions and the inertia asks for r x e, so short arms get more thrust.
# Seen (ezauv 0.1.9): Motor divides r x e by its norm. Four thrusters on arms of 0.141 m and of 1.41 m get the same thrusts,
#   0.25 each, for a yaw of 1 rad/s2 with an inertia of 1 kg m2; they make 0.14 and 1.41 N m. Sideways force is right.
#   On arms of 0.28 and 1.41 m a demand for 1 of sway alone makes 0.8 N m of yaw beside it.
# Consequence: gains tuned on one frame are wrong on the next, and axes that look decoupled are not. Give positions with
#   arms of 1 m and fold true arms into the inertia where all are alike; where they differ nothing helps.
# Gurobi 13 in place of the version that it asks for, whose free licence has ended. T's geometry is that of its README.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check gurobipy==13.0.3 numpy scipy pygame imageio
"$folder/env/bin/pip" install --quiet --no-deps --disable-pip-version-check ezauv==0.1.9
"$folder/env/bin/python" - > "$folder/shown" <<'PYTHON'
from importlib.metadata import version

import numpy as np
from ezauv import AccelerationState
from ezauv.hardware import Motor, MotorController
from scipy.spatial.transform import Rotation

CORNERS = np.array([[-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]])
WAYS = np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0]])


def made(positions, **asked):
    """Thrusts of an answer, the force and the moment that they make."""
    limits, none = Motor.Range(-10.0, 10.0), Motor.Range(0.0, 0.0)
    motors = [Motor(way, at, print, lambda: 0, limits, none) for at, way in zip(positions, WAYS, strict=True)]
    controller = MotorController(inertia=np.eye(3), motors=motors)
    is_solved, f = controller.solve(AccelerationState(local=False, **asked), Rotation.identity())
    assert is_solved
    forces = np.array(f)[:, None] * WAYS / np.linalg.norm(WAYS, axis=1, keepdims=True)
    return np.array(f), forces.sum(axis=0), np.cross(positions, forces).sum(axis=0)


yaws = {side: made(side * CORNERS, Rz=1.0) for side in (0.1, 1.0)}
print()
for side, (f, force, moment) in yaws.items():
    print(f"ezauv {version('ezauv')}, arms {side * 2**0.5:.3f} m, asked yaw 1: thrusts {f.round(3)}, yaw {moment[2]:.3f} N m")
    assert np.allclose(np.abs(f), 0.25, atol=1e-6) and np.allclose(force, 0.0, atol=1e-6)
    assert abs(moment[2] - side * 2**0.5) < 1e-6
sway = made(0.1 * CORNERS, Ty=1.0)
assert np.allclose(sway[1], [0.0, 1.0, 0.0], atol=1e-6)
uneven = np.array([[0.2], [0.2], [1.0], [1.0]]) * CORNERS
_, force, moment = made(uneven, Ty=1.0)
print(f"arms 0.28 and 1.41 m, asked sway 1: force {force.round(3) + 0.0}, moment {moment.round(3) + 0.0}")
assert abs(moment[2]) > 0.1
PYTHON
tail -n 3 "$folder/shown"  # Gurobi and pygame print more
