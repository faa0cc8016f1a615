#!/usr/bin/env bash
# ezauv gives thrusts inside the dead zone that its integer program is there to avoid.
#
# Guess: with deadzone [-0.1, 0.1], as its README's example has it, each thrust is exactly 0 or at least 0.1 in
#   size, as the comment there says, and bounds of [-0.9, 0.5] let a motor pull back with 0.9.
# Seen (ezauv 0.1.9): the sign of the zone's lower end is turned round, so forward thrusts avoid it and others may be as high
#   as +0.1: of 200 demands that thrusts outside the zone can make, 106 have one inside, with success. And the upper bound is
#   taken for both ways: with [-0.9, 0.5] a demand for -0.8 of each of four gets -0.5.
# Consequence: small thrusts are commanded that the propellers don't make. Give the zone's lower end as +0.1: then all 200
#   are outside. Nothing widens the bound.
# Gurobi 13 in place of the version that it asks for, whose free licence has ended. T's geometry is that of its README.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check gurobipy==13.0.3 numpy scipy pygame imageio
"$folder/env/bin/pip" install --quiet --no-deps --disable-pip-version-check ezauv==0.1.9
"$folder/env/bin/python" - > "$folder/shown" <<'PYTHON'
from importlib.metadata import version

import numpy as np
from ezauv.hardware import Motor, MotorController

CORNERS = np.array([[-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]])
WAYS = np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0]])


def controller_of(bounds, zone):
    ranges = Motor.Range(*bounds), Motor.Range(*zone)
    motors = [Motor(way, at, print, lambda: 0, *ranges) for at, way in zip(CORNERS, WAYS, strict=True)]
    return MotorController(inertia=np.eye(3), motors=motors)


def inside(zone):
    """Number of 200 demands that thrusts outside the zone make, and that are answered with one inside it."""
    controller, rng, count = controller_of((-0.9, 0.9), zone), np.random.default_rng(0), 0
    for _ in range(200):
        possible = np.where(rng.random(4) < 0.3, 0.0, rng.choice([-1.0, 1.0], 4) * rng.uniform(0.1, 0.9, 4))
        is_solved, f = controller.optimizer.optimize(controller.motor_matrix @ possible)
        assert is_solved
        count += bool(((np.abs(f) > 1e-4) & (np.abs(f) < 0.1 - 1e-4)).any())
    return count


found = {zone: inside(zone) for zone in ((-0.1, 0.1), (0.1, 0.1))}
back = controller_of((-0.9, 0.5), (0.0, 0.0))
_, f = back.optimizer.optimize(back.motor_matrix @ np.full(4, -0.8))
print(f"\nezauv {version('ezauv')}: of 200 answers with a thrust inside, by deadzone: {found}; of -0.8 each: {f.round(3)}")
assert found[-0.1, 0.1] > 50 and found[0.1, 0.1] == 0
assert np.allclose(f, -0.5, atol=1e-4)
PYTHON
tail -n 1 "$folder/shown"  # Gurobi and pygame print more
