"""PX4 ULog (library pyulog, extra ``px4``): setpoints, outputs and batteries.

Setpoints, ``vehicle_thrust_setpoint`` and ``vehicle_torque_setpoint``, are normalised: 1 is what the vehicle
can do on an axis, not 1 N; ``--scale`` turns them into newtons. Axes are x forward, y starboard, z down.

Each driver of outputs (a bank: PWM_MAIN, PWM_AUX, UAVCAN_EC, …) publishes an instance of actuator_outputs.
Instances are numbered as the drivers start, which differs from board to board, and no field names the bank.
The parameters BANK_FUNCn say which motor each of its outputs drives. The instance of a bank is known where
only one reading of the log fits its parameters; else the user says it.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from io import StringIO
from itertools import permutations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError, NotInstalled
from alloc.vehicle.geometry import DOF
from bench.inputs.demand_csv import Demanded
from bench.inputs.frames import Stated
from bench.inputs.log_files import DAMAGED, parsing, timed
from bench.inputs.outputs import (
    Outputs,
    Sensors,
    battery_amps,
    battery_volts,
    hold_last,
    join_rows,
    mirror_doubt,
    motor_channels,
)

SUFFIXES = (".ulg", ".ulog")
TOPIC = True
"""``read_outputs`` takes instances of banks: ``PWM_MAIN=0,PWM_AUX=1``; a number alone without parameters."""
THRUST, TORQUE = "vehicle_thrust_setpoint", "vehicle_torque_setpoint"
XYZ = ("xyz[0]", "xyz[1]", "xyz[2]")
OUTPUTS, BATTERY = "actuator_outputs", "battery_status"
FORCE, RATES = "vehicle_acceleration", "vehicle_angular_velocity"
ATTITUDE, POSITION = "vehicle_attitude", "vehicle_local_position"
SENSED = (FORCE, RATES, ATTITUDE, POSITION)
PX4 = Stated("frd", "as PX4 has it")
FIRST_MOTOR = 101
"""Value of BANK_FUNCn for motor 1."""
FUNCTION = re.compile(r"(\w+)_FUNC(\d+)")
Columns = Mapping[str, Any]
Instances = dict[int, dict[str, Any]]
"""The columns of each instance of a message that has rows, by the instance's number."""


def read_ulog(path: Path, *messages: str) -> tuple[dict[str, Instances], dict[str, Any], str]:
    """The instances of each of these messages in a ULog, the parameters at its start, and what is odd.

    What is odd is text to be added to what is said of the log, empty for nothing. Raises NotInstalled without
    pyulog, and within ``parsing`` FileError for what is no ULog.
    """
    try:
        from pyulog.core import ULog
    except ImportError:
        raise NotInstalled("reading ULogs needs pyulog; pip install 'thrustbench[px4]'") from None
    # pyulog prints warnings of damaged parts, but standard output is for results.
    with path.open("rb") as file, redirect_stdout(StringIO()):
        log = ULog(file, list(messages))
    sets: dict[str, Instances] = {name: {} for name in messages}
    for data in sorted(log.data_list, key=lambda data: data.multi_id):
        if len(data.data["timestamp"]):
            sets[data.name][data.multi_id] = data.data
    return sets, log.initial_parameters, DAMAGED if log.file_corruption else ""


def read(path: Path, topic: str) -> Demanded:
    """One demand a thrust setpoint, with the torque setpoint that held then; none before the first torque.

    The topic is the number of an instance, as a VTOL has one for hovering and one for cruising.
    """
    with parsing(path, "ULog", "pyulog"):
        sets, _, remark = read_ulog(path, THRUST, TORQUE)
        return _chosen(path, sets, topic)._replace(notes=remark)


def _chosen(path: Path, sets: dict[str, Instances], topic: str) -> Demanded:
    for name in (THRUST, TORQUE):
        if not sets[name]:
            raise DemandError(f"{path}: holds no {name}; log it (SDLOG_PROFILE, default set)")
    both = sorted(sets[THRUST].keys() & sets[TORQUE].keys())
    logs = {str(i): _setpoints(path, sets[THRUST][i], sets[TORQUE][i]) for i in both}
    if topic in logs:
        return logs[topic]
    if topic or not logs:
        raise DemandError(
            f"{path}: no instance {topic!r} of both {THRUST} and {TORQUE}; there are"
            f" {', '.join(logs) or 'none'}"
        )
    if len(logs) > 1:
        most = ", ".join(
            f"{i} (at most {np.nan_to_num(np.abs(log.taus)).max(initial=0):.3g})" for i, log in logs.items()
        )
        raise DemandError(f"{path}: demands in instances {most}; choose one as {path}#{next(iter(logs))}")
    return next(iter(logs.values()))


def _setpoints(path: Path, thrust: Columns, torque: Columns) -> Demanded:
    """Demands of one instance: each thrust with the torque that held then, from the first torque on."""
    (times, forces), (since, moments) = (_timed(path, data, *XYZ) for data in (thrust, torque))
    kept = times >= since[0]
    taus = np.hstack([forces[kept], hold_last(since, moments, times[kept])])
    return Demanded(times[kept] - times[kept][:1], taus, stated=PX4, shares=True)


class Pin(NamedTuple):
    """An output: its bank, its number there, from 1, and the instance that logs it."""

    bank: str
    channel: int
    instance: int


class Wiring(NamedTuple):
    """The instance of each bank, None where it is not logged, and the pin of each motor."""

    instances: dict[str, int | None]
    pins: list[Pin]

    def as_topic(self) -> str:
        """The banks of the motors, as ``--topic`` names them."""
        used = {pin.bank: pin.instance for pin in self.pins}
        return ",".join(f"{bank}={i}" if bank else str(i) for bank, i in used.items())


def read_outputs(path: Path, vehicle: Vehicle, topic: str = "", sensed: bool = False) -> Outputs:
    """The outputs of a vehicle's motors, motor 1 first; setpoints are shares of what the vehicle can do.

    With ``sensed`` the sensors too.
    """
    with parsing(path, "ULog", "pyulog"):
        log = read_ulog(path, OUTPUTS, BATTERY, THRUST, TORQUE, *(SENSED if sensed else ()))
        outputs = _outputs(path, vehicle, *log, topic)
        return outputs._replace(sensors=_sensors(path, log[0])) if sensed else outputs


def _sensors(path: Path, sets: dict[str, Instances]) -> Sensors:
    """Specific force, rates, attitude and valid velocities, of the first instance of each."""
    for name in SENSED:
        if not sets[name]:
            raise DemandError(f"{path}: holds no {name}; log it (SDLOG_PROFILE, default set)")
    force, rates, attitude, position = (sets[name][min(sets[name])] for name in SENSED)
    times, q = _timed(path, attitude, *(f"q[{i}]" for i in (1, 2, 3, 0)))
    moved, v = _timed(path, position, "vx", "vy", "vz", "v_xy_valid", "v_z_valid")
    known = (v[:, 3:] > 0).all(axis=1)
    if not known.any():
        raise DemandError(f"{path}: {POSITION} has no valid velocity; that takes a DVL or a fix")
    velocity = moved[known], v[known, :3]
    said = f"{FORCE}, {RATES}, {ATTITUDE} and {POSITION}"
    return Sensors(_timed(path, force, *XYZ), _timed(path, rates, *XYZ), (times, q), velocity, said)


def _outputs(
    path: Path,
    vehicle: Vehicle,
    sets: dict[str, Instances],
    parameters: dict[str, Any],
    odd: str,
    topic: str = "",
) -> Outputs:
    if not sets[OUTPUTS]:
        raise DemandError(f"{path}: holds no {OUTPUTS}; log it (SDLOG_PROFILE, default set)")
    wiring, times, u, lost = _match_wiring(path, vehicle, sets[OUTPUTS], parameters, topic)
    volts, of_volts = battery_volts(
        path,
        {i: _timed(path, data, "voltage_v") for i, data in sets[BATTERY].items() if "voltage_v" in data},
        times,
    )
    amps = battery_amps(
        {i: _timed(path, data, "current_a") for i, data in sets[BATTERY].items() if "current_a" in data},
        times,
    )
    taus, of_taus = None, ""
    if any(len(sets[name]) > 1 for name in (THRUST, TORQUE)):
        of_taus = f"{path.name}: several instances of {THRUST} or {TORQUE}; none is compared with the outputs"
    elif all(sets[name] for name in (THRUST, TORQUE)):
        asked = [next(iter(sets[name].values())) for name in (THRUST, TORQUE)]
        six = np.hstack([hold_last(*_timed(path, data, *XYZ), times) for data in asked])
        taus = six[:, [DOF.index(axis) for axis in vehicle.dof]]
    banks = dict.fromkeys(pin.bank for pin in wiring.pins)
    named = {pin: f"{pin.bank} {pin.channel}" if len(banks) > 1 else str(pin.channel) for pin in wiring.pins}
    said = f"{path.name}: outputs {', '.join(named.values())} are the thrusters, in this order"
    if len(sets[OUTPUTS]) > 1:
        said += f"; instances of {OUTPUTS}: {wiring.as_topic()}"
    ways = {
        i: bool(int(parameters[key]) >> (pin.channel - 1) & 1)
        for i, pin in enumerate(wiring.pins)
        if (key := f"{pin.bank or 'PWM_MAIN'}_REV") in parameters
    }
    reversals = " or ".join(f"{bank or 'PWM_MAIN'}_REV" for bank in banks)
    doubts = (mirror_doubt(path, vehicle, ways, reversals), of_volts, of_taus)
    return Outputs(
        times - times[:1],
        u,
        volts,
        taus,
        shares=True,
        notes="; ".join(filter(None, (said + lost, odd))),
        stated=PX4,
        doubt="; ".join(filter(None, doubts)),
        amps=amps,
        start=float(times[0]) if len(times) else 0.0,
    )


def _match_wiring(
    path: Path, vehicle: Vehicle, instances: Instances, parameters: Columns, topic: str
) -> tuple[Wiring, FloatArray, FloatArray, str]:
    """The only reading that fits the log, with its times (N,), commands (N, n) and a word on lost rows.

    Raises DemandError where none fits, and where two that do have other commands.
    """
    banks: dict[str, dict[int, int]] = {}
    for name, value in parameters.items():
        if match := FUNCTION.fullmatch(name):
            banks.setdefault(match[1], {})[int(match[2])] = int(value)
    motors = range(FIRST_MOTOR, FIRST_MOTOR + vehicle.n)
    drives = {function: c for functions in banks.values() for c, function in functions.items()}
    channels = motor_channels(
        path, [drives.get(motor) for motor in motors], "PWM_MAIN_FUNCn or PWM_AUX_FUNCn"
    )
    if not drives.keys() & set(motors):
        banks = {"": dict(zip(channels, motors, strict=True))}
    # A driver none of whose outputs has a function publishes nothing.
    active = {bank: functions for bank, functions in banks.items() if any(functions.values())}
    wirings = list(_possible_wirings(active, list(instances), motors))
    if not wirings:
        carriers = [bank for bank, functions in active.items() if {*motors} & {*functions.values()}]
        raise DemandError(
            f"{path}: motors are on {' and '.join(carriers)}, but {OUTPUTS} has {len(instances)} instance;"
            " log one of each (SDLOG_PROFILE, default set)"
        )
    fitting = [
        wiring
        for wiring in wirings
        if all(pin.channel <= _count(instances[pin.instance]) for pin in wiring.pins)
    ]
    if not fitting:
        raise DemandError(
            f"{path}: {OUTPUTS} has no output {max(channels)}, but {vehicle.name} has {vehicle.n} thrusters;"
            " is the log of this vehicle?"
        )
    if topic:
        told = set(topic.replace(" ", "").split(","))
        fitting = [wiring for wiring in fitting if set(wiring.as_topic().split(",")) == told]
    else:
        for test in (_fits, _counts):
            good = {
                (bank, i)
                for bank, functions in active.items()
                for i, data in instances.items()
                if test(bank, functions, data, parameters)
            }
            fitting = [
                wiring
                for wiring in fitting
                if all((bank, i) in good for bank, i in wiring.instances.items() if i is not None)
            ] or fitting
    if not fitting:
        raise DemandError(
            f"{path}: --topic {topic!r} names none of its banks; give {' or '.join(_topics(wirings))}"
        )
    first = _commands(path, fitting[0].pins, instances)
    for pins in dict.fromkeys(tuple(wiring.pins) for wiring in fitting[1:]):
        if not np.array_equal(_commands(path, pins, instances)[1], first[1], equal_nan=True):
            raise DemandError(
                f"{path}: nothing in it says which instance of {OUTPUTS} drives which motors; it may be"
                f" {' or '.join(_topics(fitting))}: give the right one as --topic"
            )
    return fitting[0], *first


def _topics(wirings: Sequence[Wiring]) -> list[str]:
    return list(dict.fromkeys(wiring.as_topic() for wiring in wirings))


def _possible_wirings(
    active: Mapping[str, Mapping[int, int]], instances: Sequence[int], motors: Sequence[int]
) -> Iterator[Wiring]:
    """Every way to give each bank an instance of its own, or none where there are too few."""
    spare = [None] * max(0, len(active) - len(instances))
    for chosen in dict.fromkeys(permutations([*instances, *spare], len(active))):
        given = dict(zip(active, chosen, strict=True))
        # A motor may be on two banks; the pin that is put in last remains.
        for order in (list(given.items())[::-1], list(given.items())):
            pins = {
                function: Pin(bank, channel, instance)
                for bank, instance in order
                if instance is not None
                for channel, function in sorted(active[bank].items(), reverse=True)
            }
            if all(motor in pins for motor in motors):
                yield Wiring(given, [pins[motor] for motor in motors])


def _count(data: Columns) -> int:
    """The number of outputs that an instance has."""
    columns = sum(name.startswith("output[") for name in data)
    return min(columns, int(np.max(data["noutputs"]))) if "noutputs" in data else columns


def _fits(bank: str, functions: Mapping[int, int], data: Columns, parameters: Columns) -> bool:
    """True if an instance holds what the driver of a bank sends by the parameters."""
    return all(
        _sent(np.unique(data[f"output[{c - 1}]"]), bool(function), bank, c, parameters)
        if c <= _count(data)
        else not function  # a pin for capture has a parameter and no output
        for c, function in functions.items()
    )


def _sent(values: FloatArray, drives: bool, bank: str, c: int, parameters: Columns) -> bool:
    """True if output c of a bank may have had these values.

    An output that drives something has pulses from BANK_MINn to BANK_MAXn, not 0 all the time; one that does
    not has one value. Any may have 0, BANK_DISn or BANK_FAILn. DShot has a range of its own.
    """
    low, high, disarmed, failsafe = (
        float(parameters.get(f"{bank}_{key}{c}", np.nan)) for key in ("MIN", "MAX", "DIS", "FAIL")
    )
    if drives and not values.any():
        return False
    dshot = any(value < -1 for name, value in parameters.items() if name.startswith(f"{bank}_TIM"))
    if dshot or np.isnan([low, high, disarmed]).any():
        return drives or len(values) == 1
    rest = values[~np.isin(values, [0, disarmed, failsafe])]
    return bool((drives & (rest >= min(low, disarmed)) & (rest <= high)).all())


def _counts(bank: str, functions: Mapping[int, int], data: Columns, _: Columns) -> bool:
    """True if an instance has as many outputs as a bank has parameters BANK_FUNCn."""
    return not bank or ("noutputs" in data and len(functions) == np.max(data["noutputs"]))


def _commands(path: Path, pins: Sequence[Pin], instances: Instances) -> tuple[FloatArray, FloatArray, str]:
    """Times (N,) [s] and commands (N, n) of the motors, and what is said of rows that are left out."""
    by_instance: dict[int, list[int]] = {}
    for motor, pin in enumerate(pins):
        by_instance.setdefault(pin.instance, []).append(motor)
    times, values, lost = join_rows(
        [
            _timed(path, instances[i], *(f"output[{pins[motor].channel - 1}]" for motor in there))
            for i, there in by_instance.items()
        ]
    )
    return times, values[:, np.argsort([motor for there in by_instance.values() for motor in there])], lost


def _timed(path: Path, data: Columns, *keys: str) -> tuple[FloatArray, FloatArray]:
    """Times (N,) [s] and what was logged then (N, keys), in order."""
    return timed(path, data["timestamp"], [data[key] for key in keys])
