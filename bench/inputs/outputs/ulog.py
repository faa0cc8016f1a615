"""PX4 ULog: ``actuator_outputs``, ``battery_status`` and the setpoints (library pyulog, extra ``px4``)."""

from pathlib import Path
from typing import Any

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle.geometry import DOF
from bench.inputs.outputs import Outputs, held, mirrored, motor_channels
from bench.inputs.parsers import parsing, read_ulog
from bench.inputs.time_order import in_order

SUFFIXES = (".ulg", ".ulog")
OUTPUTS, BATTERY = "actuator_outputs", "battery_status"
ASKED = ("vehicle_thrust_setpoint", "vehicle_torque_setpoint")
FIRST_MOTOR = 101
"""Value of PWM_MAIN_FUNCn and PWM_AUX_FUNCn for motor 1."""


def read(path: Path, vehicle: Vehicle) -> Outputs:
    """The outputs of a vehicle's motors, motor 1 first; setpoints are shares of what the vehicle can do."""
    with parsing(path, "ULog", "pyulog"):
        return _outputs(path, vehicle, *read_ulog(path, OUTPUTS, BATTERY, *ASKED))


def _outputs(
    path: Path, vehicle: Vehicle, sets: dict[str, dict[str, Any]], parameters: dict[str, Any], odd: str
) -> Outputs:
    if OUTPUTS not in sets or not len(sets[OUTPUTS]["timestamp"]):
        raise DemandError(f"{path}: holds no {OUTPUTS}; log it (SDLOG_PROFILE, default set)")
    pins = {
        parameters[f"PWM_{bank}_FUNC{c}"]: (bank, c)
        for bank in ("AUX", "MAIN")
        for c in range(1, 17)
        if f"PWM_{bank}_FUNC{c}" in parameters
    }
    drives = {function: c for function, (_, c) in pins.items()}
    wanted = [drives.get(FIRST_MOTOR + i) for i in range(vehicle.n)]
    channels = motor_channels(path, wanted, "PWM_MAIN_FUNCn or PWM_AUX_FUNCn")
    out = sets[OUTPUTS]
    if f"output[{max(channels) - 1}]" not in out:
        raise DemandError(
            f"{path}: {OUTPUTS} has no output {max(channels)}, but {vehicle.name} has {vehicle.n}"
            " thrusters; is the log of this vehicle?"
        )
    times, u = _timed(path, out, *(f"output[{c - 1}]" for c in channels))
    volts = taus = None
    if BATTERY in sets and "voltage_v" in sets[BATTERY]:
        volts = held(*_timed(path, sets[BATTERY], "voltage_v"), times)[:, 0]
    if all(name in sets and len(sets[name]["timestamp"]) for name in ASKED):
        xyz = [f"xyz[{i}]" for i in range(3)]
        six = np.hstack([held(*_timed(path, sets[name], *xyz), times) for name in ASKED])
        taus = six[:, [DOF.index(axis) for axis in vehicle.dof]]
    said = f"{path.name}: outputs {', '.join(map(str, channels))} are the thrusters, in this order"
    ways = {
        i: bool(int(parameters[key]) >> (c - 1) & 1)
        for i in range(vehicle.n)
        for bank, c in [pins.get(FIRST_MOTOR + i, ("MAIN", i + 1))]
        if (key := f"PWM_{bank}_REV") in parameters
    }
    return Outputs(
        times - times[0],
        u,
        volts,
        taus,
        shares=True,
        said=said + odd,
        frame="frd",
        why="as PX4 has it",
        doubt=mirrored(path, vehicle, ways, "PWM_MAIN_REV or PWM_AUX_REV"),
    )


def _timed(path: Path, data: dict[str, Any], *keys: str) -> tuple[FloatArray, FloatArray]:
    """Times (N,) [s] and what was logged then (N, keys), in order."""
    times = np.asarray(data["timestamp"], dtype=np.float64) / 1e6
    order = in_order(path, times)
    return times[order], np.column_stack([np.asarray(data[key], dtype=np.float64) for key in keys])[order]
