"""Small logs of outputs, written by the libraries that read them."""

import io
import struct
from pathlib import Path

import numpy as np
from pyulog.core import ULog

from alloc.allocation import FloatArray

FORMATS = {
    "PARM": (64, "QNff", "TimeUS,Name,Value,Default"),
    "RCOU": (65, "QHHHHHHHH", "TimeUS,C1,C2,C3,C4,C5,C6,C7,C8"),
    "BAT": (66, "QBf", "TimeUS,Inst,Volt"),
    "ATT": (68, "Qffffff", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    "RATE": (67, "Qfff", "TimeUS,ROut,POut,YOut"),
}
"""Message types of a dataflash log, with fewer fields than ArduPilot's."""
PACKED = str.maketrans({"N": "16s", "Z": "64s", "n": "4s"})


def write_bin(
    path: Path,
    t: FloatArray,
    u: FloatArray,
    volts: FloatArray,
    rate: FloatArray,
    first_motor: int = 1,
    mirrored: tuple[int, ...] = (),
) -> Path:
    """A dataflash log of eight outputs; motor 1 is on output ``first_motor``, the others follow."""
    packed = {0x80: "BB4s16s64s"}
    out = bytearray()

    def put(kind: int, *values: object) -> None:
        out.extend(b"\xa3\x95" + bytes([kind]) + struct.pack("<" + packed[kind], *values))

    for name, (kind, fields, columns) in {
        "FMT": (0x80, "BBnNZ", "Type,Length,Name,Format,Columns"),
        **FORMATS,
    }.items():
        packed[kind] = fields.translate(PACKED)
        size = 3 + struct.calcsize("<" + packed[kind])
        put(0x80, kind, size, name.encode(), fields.encode(), columns.encode())
    place = (np.arange(8) + first_motor - 1) % 8
    for motor, output in enumerate(place):
        put(64, 1, f"SERVO{output + 1}_FUNCTION".encode(), 33.0 + motor, 0.0)
        put(64, 1, f"MOT_{motor + 1}_DIRECTION".encode(), -1.0 if motor + 1 in mirrored else 1.0, 0.0)
    for time, row, volt, asked in zip(t, u, volts, rate, strict=True):
        stamp = 1_000_000 + round(time * 1e6)
        wire = np.empty(8, dtype=int)
        wire[place] = row
        put(66, stamp, 0, volt)
        put(67, stamp, *asked)
        put(68, stamp, 1.0, 3.0, 0.0, -1.0, 359.0, 2.0)  # off by 2, 1 and 3 degrees
        put(65, stamp, *wire.tolist())
    file = path / "dive.BIN"
    file.write_bytes(out)
    return file


def write_outputs_ulog(path: Path, t: FloatArray, u: FloatArray, volts: FloatArray, taus: FloatArray) -> Path:
    """A ULog of outputs, battery and setpoints (N, 6), by pyulog's own writer."""
    log = ULog(io.BytesIO(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000)))
    sets = {
        "actuator_outputs": {f"output[{i}]": column for i, column in enumerate(u.T)},
        "battery_status": {"voltage_v": volts},
        "vehicle_thrust_setpoint": {f"xyz[{i}]": column for i, column in enumerate(taus.T[:3])},
        "vehicle_torque_setpoint": {f"xyz[{i}]": column for i, column in enumerate(taus.T[3:])},
    }
    for msg_id, (name, columns) in enumerate(sets.items()):
        fields = [("uint64_t", 0, "timestamp")]
        array = len(columns) > 1
        fields.append(("float", len(columns) if array else 0, next(iter(columns)).partition("[")[0]))
        log._message_formats[name] = ULog.MessageFormat.__new__(ULog.MessageFormat)
        log._message_formats[name].name, log._message_formats[name].fields = name, fields
        data = ULog.Data.__new__(ULog.Data)
        data.name, data.multi_id, data.msg_id = name, 0, msg_id
        data.field_data = [ULog._FieldData("timestamp", "uint64_t")]
        data.field_data += [ULog._FieldData(column, "float") for column in columns]
        stamps = (1_000_000 + np.round(t * 1e6)).astype(np.uint64)
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
