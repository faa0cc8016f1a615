"""Small logs of outputs, written by the libraries that read them."""

import io
import struct
from collections import Counter
from pathlib import Path

import numpy as np
from pyulog.core import ULog
from scipy.spatial.transform import Rotation

from alloc.allocation import FloatArray
from tests.dives import SensorLog

FORMATS = {
    "PARM": (64, "QNff", "TimeUS,Name,Value,Default"),
    "BAT": (66, "QBff", "TimeUS,Inst,Volt,Curr"),
    "ATT": (68, "Qffffff", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    "RATE": (67, "Qfff", "TimeUS,ROut,POut,YOut"),
    "IMU": (71, "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    "XKF1": (72, "QBccCfff", "TimeUS,C,Roll,Pitch,Yaw,VN,VE,VD"),
}
"""Message types of a dataflash log, with fewer fields than ArduPilot's."""
PULSES = {"RCOU": range(1, 15), "RCO2": range(15, 19), "RCO3": range(19, 33)}
"""Outputs in each message of a dataflash log."""
PACKED = str.maketrans({"N": "16s", "Z": "64s", "n": "4s", "c": "h", "C": "H"})


def write_bin(
    path: Path,
    t: FloatArray,
    u: FloatArray,
    volts: FloatArray,
    rate: FloatArray,
    first_motor: int = 1,
    mirrored: tuple[int, ...] = (),
    outputs: tuple[int, ...] = (),
    functions: tuple[int, ...] = tuple(range(33, 41)),
    second_pack: FloatArray | None = None,
    amps: FloatArray | None = None,
    sensors: SensorLog | None = None,
) -> Path:
    """A dataflash log of eight outputs; motor 1 is on output ``first_motor``, the others follow.

    Without ``amps`` nothing measures the current, which is NaN then, as in ArduPilot.

    With ``outputs`` of the motors, from 1 to 32, the log has RCOU, RCO2 and RCO3 as ArduPilot writes them:
    one after the other, each only where one of its outputs is in use.
    """
    groups = PULSES if outputs else {"RCOU": range(1, 9)}
    pulses = {
        name: (kind, "Q" + "H" * len(group), ",".join(["TimeUS", *(f"C{c}" for c in group)]))
        for kind, (name, group) in zip((65, 69, 70), groups.items(), strict=False)
        if not outputs or set(outputs) & set(group)
    }
    packed = {0x80: "BB4s16s64s"}
    out = bytearray()

    def put(kind: int, *values: object) -> None:
        out.extend(b"\xa3\x95" + bytes([kind]) + struct.pack("<" + packed[kind], *values))

    for name, (kind, fields, columns) in {
        "FMT": (0x80, "BBnNZ", "Type,Length,Name,Format,Columns"),
        **FORMATS,
        **pulses,
    }.items():
        packed[kind] = fields.translate(PACKED)
        size = 3 + struct.calcsize("<" + packed[kind])
        put(0x80, kind, size, name.encode(), fields.encode(), columns.encode())
    place = np.array(outputs) - 1 if outputs else (np.arange(8) + first_motor - 1) % 8
    for motor, output in enumerate(place):
        put(64, 1, f"SERVO{output + 1}_FUNCTION".encode(), float(functions[motor]), 0.0)
        put(64, 1, f"MOT_{motor + 1}_DIRECTION".encode(), -1.0 if motor + 1 in mirrored else 1.0, 0.0)
    packs = [volts] if second_pack is None else [volts, second_pack]
    currents = np.full(len(t), np.nan) if amps is None else amps
    for time, row, asked, current, *measured in zip(t, u, rate, currents, *packs, strict=True):
        stamp = 1_000_000 + round(time * 1e6)
        wire = np.zeros(32, dtype=int)
        wire[place] = row
        for pack, volt in enumerate(measured):
            put(66, stamp, pack, volt, current)
        put(67, stamp, *asked)
        put(68, stamp, 1.0, 3.0, 0.0, -1.0, 359.0, 2.0)  # off by 2, 1 and 3 degrees
        for late, (name, (kind, *_)) in enumerate(pulses.items()):
            put(kind, stamp + 150 * late, *(wire[c - 1] for c in groups[name]))
    for time, force, w, attitude, velocity in zip(*(sensors or ()), strict=True):
        stamp = 1_000_000 + round(time * 1e6)
        yaw, pitch, roll = Rotation.from_quat(attitude).as_euler("ZYX", degrees=True)
        for instance in (1, 0):  # the second of each is as wrong as can be
            wrong = 1 - 3 * instance
            put(71, stamp, instance, *(wrong * w), *(wrong * force))
            angles = (round(100 * each) for each in (roll, pitch, yaw % 360.0))
            put(72, stamp, instance, *angles, *(wrong * velocity))
    file = path / "dive.BIN"
    file.write_bytes(out)
    return file


def write_outputs_ulog(
    path: Path,
    t: FloatArray,
    u: FloatArray,
    volts: FloatArray,
    taus: FloatArray,
    amps: FloatArray | None = None,
    sensors: SensorLog | None = None,
) -> Path:
    """A ULog of outputs, battery and setpoints (N, 6), by pyulog's own writer; PX4 says -1 A for none."""
    messages = {
        "actuator_outputs": {f"output[{i}]": column for i, column in enumerate(u.T)},
        "battery_status": {"voltage_v": volts, "current_a": -np.ones(len(t)) if amps is None else amps},
        "vehicle_thrust_setpoint": {f"xyz[{i}]": column for i, column in enumerate(taus.T[:3])},
        "vehicle_torque_setpoint": {f"xyz[{i}]": column for i, column in enumerate(taus.T[3:])},
    }
    rows = [(name, 0, t, columns) for name, columns in messages.items()]
    if sensors is not None:
        xyz = {"vehicle_acceleration": sensors.force, "vehicle_angular_velocity": sensors.rates}
        quantities = {
            name: {f"xyz[{i}]": each for i, each in enumerate(values.T)} for name, values in xyz.items()
        }
        quantities["vehicle_attitude"] = {f"q[{i}]": sensors.attitude[:, i - 1] for i in range(4)}
        valid = {name: np.ones(len(sensors.t)) for name in ("v_xy_valid", "v_z_valid")}
        velocity = dict(zip(("vx", "vy", "vz"), sensors.velocity.T, strict=True))
        quantities["vehicle_local_position"] = velocity | valid
        rows += [(name, 0, sensors.t, columns) for name, columns in quantities.items()]
    return write_ulog_of(path, rows)


def write_banks(
    path: Path, t: FloatArray, banks: dict[int, FloatArray], parameters: dict[str, int], late: float = 5e-6
) -> Path:
    """A ULog of the outputs (N, m) of each instance, one ``late`` [s] after the other, and parameters.

    There are 16 outputs, of which ``noutputs`` are in use, as in PX4's message.
    """
    messages = []
    for order, (instance, u) in enumerate(banks.items()):
        columns = {"noutputs": np.full(len(t), u.shape[1])}
        columns |= {f"output[{i}]": u[:, i] if i < u.shape[1] else 0 * t for i in range(16)}
        messages.append(("actuator_outputs", instance, t + order * late, columns))
    return write_ulog_of(path, messages, parameters)


def write_ulog_of(
    path: Path,
    messages: list[tuple[str, int, FloatArray, dict[str, FloatArray]]],
    parameters: dict[str, int] | None = None,
) -> Path:
    """A ULog of messages: name, instance, times and columns."""
    log = ULog(io.BytesIO(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000)))
    log._initial_parameters = dict(parameters or {})
    for msg_id, (name, instance, times, columns) in enumerate(messages):
        fields = [("uint64_t", 0, "timestamp")]
        arrays = Counter(column.partition("[")[0] for column in columns)
        fields += [("float", n if n > 1 else 0, field) for field, n in arrays.items()]
        log._message_formats[name] = ULog.MessageFormat.__new__(ULog.MessageFormat)
        log._message_formats[name].name, log._message_formats[name].fields = name, fields
        data = ULog.Data.__new__(ULog.Data)
        data.name, data.multi_id, data.msg_id = name, instance, msg_id
        data.field_data = [ULog._FieldData("timestamp", "uint64_t")]
        data.field_data += [ULog._FieldData(column, "float") for column in columns]
        stamps = (1_000_000 + np.round(times * 1e6)).astype(np.uint64)
        data.data = {"timestamp": stamps} | {
            key: values.astype(np.float32) for key, values in columns.items()
        }
        log._data_list.append(data)
    file = path / "dive.ulg"
    log.write_ulog(str(file))
    return file


def write_csv(path: Path, t: FloatArray, u: FloatArray, volts: FloatArray, rate: FloatArray) -> Path:
    """A table of times, voltages and commands."""
    file = path / "dive.csv"
    header = ["t", "volts", *(f"u{i}" for i in range(u.shape[1]))]
    lines = [",".join(map(repr, row)) for row in np.column_stack([t, volts, u]).tolist()]
    file.write_text("\n".join([",".join(header), *lines, ""]), encoding="utf-8")
    return file
