"""Factors of ArduSub's custom frame by the geometry, as C++ for its firmware: no parameter has any.

A factor is a thruster's output for input 1: the column of T* of that axis, turned into ArduSub's sense of it,
over thrust at output 1, and over the largest of its column. Inputs that saturate nothing then make their
axis and no other. Names and the order of arguments were read at ArduPilot/ardupilot 0fd5fbf258e8.
"""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.errors import VehicleError
from alloc.vehicle.autopilot import SENSE
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import VehicleFile

HELD = frozenset(
    {"dof", "frame", "T", "planar", "thrusters", "center_of_mass", "reaction_torque", "f_min", "f_max"}
    | {"weights", "H", "autopilot"}
)
"""Keys of a vehicle file that factors hold, or are made of."""
ARGUMENTS = ("roll", "pitch", "yaw", "heave", "surge", "sway")
"""Axes of the factors in the order of add_motor_raw_6dof: roll, pitch, yaw, throttle, forward, lateral."""
CUSTOM = 7
"""FRAME_CONFIG of the custom frame."""
MOTORS = 12
"""Most motors of ArduSub."""


def factors(vehicle: Vehicle) -> FloatArray:
    """(n, 6) factors of this geometry, columns as DOF, the largest of each 1 [-]; 0 for uncontrolled axes.

    MOT_n_DIRECTION of the vehicle's ``autopilot`` is taken off, 1 without one.
    """
    size = (np.maximum(vehicle.f_max, 0.0) - np.minimum(vehicle.f_min, 0.0)) / 2
    at = [DOF.index(axis) for axis in vehicle.dof]
    outputs = generalized_inverse(vehicle) * np.array(SENSE[vehicle.frame])[at] / size[:, None]
    if vehicle.autopilot is not None:
        outputs *= np.array(vehicle.autopilot.directions)[:, None]
    made = np.zeros((vehicle.n, len(DOF)))
    made[:, at] = outputs / np.abs(outputs).max(axis=0)
    return made


def write(keys: VehicleFile, vehicle: Vehicle) -> str:
    """The factors as the C++ of a custom frame; raises VehicleError for a vehicle that it can't be."""
    if vehicle.n > MOTORS:
        raise VehicleError(f"{keys.name}: {vehicle.n} thrusters; ArduSub has {MOTORS} motors")
    if (vehicle.f_min == vehicle.f_max).any():
        raise VehicleError(f"{keys.name}: a thruster that gives no thrust has no factors; leave it out")
    if vehicle.rank < vehicle.k:
        raise VehicleError(f"{keys.name}: no thrust makes each of its axes alone; leave one out of 'dof'")
    mixer = vehicle.autopilot
    motors = range(1, vehicle.n + 1) if mixer is None else mixer.motors
    order = [DOF.index(axis) for axis in ARGUMENTS]
    table = dict(zip(motors, factors(vehicle)[:, order].tolist(), strict=True))
    odd = not np.allclose(vehicle.f_min, -vehicle.f_max)
    lines = [
        f"// {keys.name}, written by thrustbench",
        "// ArduSub has no parameter for factors: put these lines into AP_Motors6DOF.cpp, build it,",
        f"// set FRAME_CONFIG = {CUSTOM}. Factors: roll, pitch, yaw, throttle, forward, lateral.",
        f"// Exact until an output saturates{' or pushes astern with another thrust' if odd else ''}.",
        "case SUB_FRAME_CUSTOM:",
        '    _frame_class_string = "CUSTOM";',
    ]
    for motor, row in sorted(table.items()):
        numbers = ", ".join(f"{round(value, 6) + 0.0:.6f}f" for value in row)
        lines.append(f"    add_motor_raw_6dof(AP_MOTORS_MOT_{motor}, {numbers}, {motor});")
    return "\n".join([*lines, "    break;"]) + "\n"
