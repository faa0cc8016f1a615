#!/usr/bin/env bash
# Crocoddyl's thruster model turns a wrench into thrusts outside the limits that its own thrusters state.
#
# Guess: thrusters are made with min_thrust and max_thrust, so commands(), the way from a wrench to thrusts, keeps them.
# Seen (crocoddyl 3.2.1): it is the pseudoinverse. Of 100 wrenches that thrusts within -40 to 50 N make, 28 get
#   thrusts beyond, by up to 22 N. Where min_thrust is left out it is 0, which suits a propeller in air: surge then asks
#   two thrusters of four to push astern, against u_lb. calc() keeps no limit either.
# Consequence: u_lb and u_ub are for a solver of optimal control; nothing else looks at them. Cut, or allocate, yourself.
# Source of T: eight thrusters of an ROV of the BlueROV2 Heavy's kind, arms rounded.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check crocoddyl==3.2.1
"$folder/env/bin/python" - <<'PYTHON'
import crocoddyl
import numpy as np
import pinocchio as pin

LOW, HIGH = -40.0, 50.0
POSES = [  # position [m], direction
    ((0.156, 0.111, 0.0), (0.707, -0.707, 0.0)),
    ((0.156, -0.111, 0.0), (0.707, 0.707, 0.0)),
    ((-0.156, 0.111, 0.0), (-0.707, -0.707, 0.0)),
    ((-0.156, -0.111, 0.0), (-0.707, 0.707, 0.0)),
    ((0.12, 0.218, 0.0), (0.0, 0.0, -1.0)),
    ((0.12, -0.218, 0.0), (0.0, 0.0, 1.0)),
    ((-0.12, 0.218, 0.0), (0.0, 0.0, 1.0)),
    ((-0.12, -0.218, 0.0), (0.0, 0.0, -1.0)),
]


def placed(position, direction):
    """The pose whose z axis is the thrust's direction."""
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(direction)).toRotationMatrix()
    return pin.SE3(turn, np.array(position))


def actuation(*limits):
    body = pin.Model()
    joint = body.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
    body.appendBodyToJoint(joint, pin.Inertia(11.5, np.zeros(3), 0.2 * np.eye(3)), pin.SE3.Identity())
    way = crocoddyl.ThrusterType.CW
    thrusters = [crocoddyl.Thruster(placed(*pose), 0.0, way, *limits) for pose in POSES]
    return crocoddyl.ActuationModelFloatingBaseThrusters(crocoddyl.StateMultibody(body), thrusters)


model = actuation(LOW, HIGH)
data, x = model.createData(), model.state.zero()
assert (model.u_lb == LOW).all() and (model.u_ub == HIGH).all()
wrenches = model.Wthrust @ np.random.default_rng(0).uniform(LOW, HIGH, (100, 8)).T
beyond = []
for wrench in wrenches.T:
    model.commands(data, x, wrench)
    assert np.allclose(data.u, np.linalg.pinv(model.Wthrust) @ wrench, atol=1e-9)
    beyond.append(max(LOW - data.u.min(), data.u.max() - HIGH, 0.0))
model.calc(data, x, np.full(8, 2 * HIGH))
assert np.allclose(data.tau, model.Wthrust @ np.full(8, 2 * HIGH))
print(f"crocoddyl 3.2.1: thrusts outside limits in {np.count_nonzero(beyond)} of 100, by up to {max(beyond):.3g} N")
one_way = actuation()
data = one_way.createData()
one_way.commands(data, x, np.array([30.0, 0, 0, 0, 0, 0]))
print(f"crocoddyl 3.2.1, no limits stated: u_lb {one_way.u_lb.min():g}, least thrust {data.u.min():.3g} N")
assert np.count_nonzero(beyond) > 0
assert (one_way.u_lb == 0).all() and data.u.min() < -5
PYTHON
