"""ArduPilot's dataflash logs: RCOU, BAT, RATE, ATT, IMU and XKF1 (library pymavlink, extra ``ardupilot``).

RCOU, RCO2 (from output 15) and RCO3 (from 19) hold the pulses of the outputs [µs], as C1 to C32, each only
where one of its outputs is in use; PARM says which motor each output drives, BAT the voltage, and RATE
what the attitude controller asked of the mixer, in shares of all that it has; ATT says how far off the
attitude was. IMU holds the inertial sensors, XKF1 attitudes [deg] and velocities [m/s] of the estimator
(EKF3). Axes are x forward, y to starboard, z down; the earth's are north, east, down.
"""

import os
import re
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError, FileError, NotInstalled
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

SUFFIXES = (".bin",)
MOTORS = (*range(33, 41), *range(82, 86), *range(160, 180))
"""SERVOn_FUNCTION of motors 1 to 32 (ArduPilot, SRV_Channel.h)."""
PULSES = ("RCOU", "RCO2", "RCO3")
ASKED = {"roll": "ROut", "pitch": "POut", "yaw": "YOut"}
ANGLES = ("Roll", "Pitch", "Yaw")
SENSED = ("Acc", "Gyr")
LOGGED = {"IMU": "IMU", "XKF1": "attitude, with EKF3 running"}
"""Bits of LOG_BITMASK that have these messages written."""
HEADER = 3
"""Bytes of the head of a message: two marks and its type."""
FORMAT = re.compile(rb"\xa3\x95\x80(?P<type>.)(?P<length>.)", re.DOTALL)
LARGEST = 2_000_000_000
"""Most bytes that are read; the bound is there for a file that grows while it is read."""


def read_outputs(path: Path, vehicle: Vehicle, _: str = "", sensed: bool = False) -> Outputs:
    """The outputs of a vehicle's motors, motor 1 first, and with ``sensed`` the sensors."""
    with parsing(path, "log", "pymavlink"):
        rows, damaged = _rows(path, *PULSES, "BAT", "RATE", "ATT", "PARM", *(LOGGED if sensed else ()))
        outputs = _outputs(path, vehicle, rows)
        outputs = outputs._replace(sensors=_sensors(path, rows)) if sensed else outputs
        return outputs._replace(notes=f"{outputs.notes}; {DAMAGED}") if damaged else outputs


def _sensors(path: Path, rows: dict[str, list[dict[str, Any]]]) -> Sensors:
    """The first inertial sensor, and the first estimator's attitude and velocity."""
    from scipy.spatial.transform import Rotation

    inertial, estimates = _first(path, rows, "IMU", "I"), _first(path, rows, "XKF1", "C")
    force, rates = (_timed(path, inertial, *(f"{kind}{axis}" for axis in "XYZ")) for kind in SENSED)
    times, angles = _timed(path, estimates, *reversed(ANGLES))
    attitude = Rotation.from_euler("ZYX", angles, degrees=True).as_quat()
    velocity = _timed(path, estimates, *(f"V{axis}" for axis in "NED"))
    return Sensors(force, rates, (times, attitude), velocity, "IMU and XKF1")


def _first(path: Path, found: dict[str, list[dict[str, Any]]], name: str, key: str) -> list[dict[str, Any]]:
    """The rows of a message's first instance; raises DemandError without any."""
    rows = found[name]
    if not rows:
        raise DemandError(f"{path}: holds no {name}; log it (LOG_BITMASK: {LOGGED[name]})")
    first = min(row.get(key, 0) for row in rows)
    return [row for row in rows if row.get(key, 0) == first]


def _rows(path: Path, *names: str) -> tuple[dict[str, list[dict[str, Any]]], bool]:
    """Rows of messages by name, and whether the log is damaged."""
    try:
        from pymavlink.DFReader import DFReader_binary
    except ImportError:
        raise NotInstalled(
            "reading ArduPilot's logs needs pymavlink; pip install 'thrustbench[ardupilot]'"
        ) from None
    # The indexer in C prints of each damaged byte past Python's streams; the one in Python can be silenced.
    os.environ.setdefault("PYMAVLINK_FAST_INDEX", "0")
    rows: dict[str, list[dict[str, Any]]] = {name: [] for name in names}
    if path.stat().st_size > LARGEST:
        raise DemandError(f"{path}: is larger than {LARGEST / 1e9:g} GB; cut it")
    _check_formats(path)
    # pymavlink prints warnings of damaged parts, but standard output is for results.
    remarks = StringIO()
    with redirect_stdout(remarks), redirect_stderr(remarks):
        log = DFReader_binary.__new__(DFReader_binary)  # its __init__ leaves the file open where it raises
        try:
            log.__init__(str(path))
            while (message := log.recv_match(type=list(rows))) is not None:
                rows[message.get_type()].append(message.to_dict())
        finally:
            for part in ("data_map", "filehandle"):
                if hasattr(log, part):
                    getattr(log, part).close()
    return rows, "bad header" in remarks.getvalue().lower()


def _check_formats(path: Path) -> None:
    """Raise FileError where a file has no format of a message, or one that is shorter than its header.

    pymavlink 2.4.50 finds nothing in the first, and stays at a message of the second for ever.
    """
    found = False
    if path.stat().st_size:  # an empty file can't be mapped
        with path.open("rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as data:
            for match in FORMAT.finditer(data):
                found = True
                if match["length"][0] < HEADER and data.find(b"\xa3\x95" + match["type"]) >= 0:
                    raise FileError(
                        f"{path}: damaged: the format at byte {match.start()} has no length; cut it out"
                    )
    if not found:
        raise FileError(
            f"{path}: no dataflash log, or an empty one; give the .BIN that the vehicle wrote, copied anew"
        )


def _outputs(path: Path, vehicle: Vehicle, rows: dict[str, list[dict[str, Any]]]) -> Outputs:
    if not any(rows[name] for name in PULSES):
        raise DemandError(f"{path}: holds no RCOU; set LOG_BITMASK so that outputs are logged")
    functions = {row["Name"]: row["Value"] for row in rows["PARM"]}
    drives = {functions.get(f"SERVO{c}_FUNCTION"): c for c in range(32, 0, -1)}
    wanted = [drives.get(MOTORS[i]) if i < len(MOTORS) else None for i in range(vehicle.n)]
    channels = motor_channels(path, wanted, "SERVOn_FUNCTION")
    beyond = [i + 1 for i in range(vehicle.n, len(MOTORS)) if MOTORS[i] in drives]
    found = {name: [c for c in channels if rows[name] and f"C{c}" in rows[name][0]] for name in PULSES}
    lacking = [c for c in channels if not any(c in there for there in found.values())]
    if lacking:
        raise DemandError(
            f"{path}: {', '.join(PULSES)} have no C{lacking[0]}, but {vehicle.name} has {vehicle.n}"
            " thrusters; is the log of this vehicle?"
        )
    t, pulses, lost = join_rows(
        [_timed(path, rows[name], *(f"C{c}" for c in there)) for name, there in found.items() if there]
    )
    order = [c for there in found.values() for c in there]
    u = pulses[:, [order.index(c) for c in channels]]
    packs: dict[int, list[dict[str, Any]]] = {}
    for row in rows["BAT"]:
        packs.setdefault(row.get("Inst", row.get("Instance", 0)), []).append(row)
    volts, of_volts = battery_volts(path, {i: _timed(path, each, "Volt") for i, each in packs.items()}, t)
    measuring = {i: each for i, each in packs.items() if "Curr" in each[0]}
    amps = battery_amps({i: _timed(path, each, "Curr") for i, each in measuring.items()}, t)
    taus = None
    if rows["RATE"]:
        taus = np.full((len(t), vehicle.k), np.nan)
        asked = hold_last(*_timed(path, rows["RATE"], *ASKED.values()), t)
        for axis, column in zip(ASKED, asked.T, strict=True):
            if axis in vehicle.dof:
                taus[:, vehicle.dof.index(axis)] = column
    said = f"{path.name}: outputs {', '.join(map(str, channels))} are the thrusters, in this order{lost}"
    if beyond:
        motors = ", ".join(map(str, beyond))
        said += f"; {vehicle.name} has none for motor {motors}: is the log of this vehicle?"
    said += _attitude(rows["ATT"])
    ways = {i: functions[key] < 0 for i in range(vehicle.n) if (key := f"MOT_{i + 1}_DIRECTION") in functions}
    return Outputs(
        t - t[:1],
        u,
        volts,
        taus,
        shares=True,
        notes=said,
        stated=Stated("frd", "as ArduPilot has it"),
        doubt="; ".join(filter(None, (mirror_doubt(path, vehicle, ways, "MOT_n_DIRECTION"), of_volts))),
        amps=amps,
        start=float(t[0]) if len(t) else 0.0,
    )


def _timed(path: Path, rows: list[dict[str, Any]], *keys: str) -> tuple[FloatArray, FloatArray]:
    """Times (N,) [s] and what was logged then (N, keys), in order."""
    return timed(path, [row["TimeUS"] for row in rows], [[row[key] for row in rows] for key in keys])


def _attitude(rows: list[dict[str, Any]]) -> str:
    """Largest of three angles between the attitude and its setpoint; empty where nothing says."""
    pairs = np.array([[row[f"Des{axis}"] - row[axis] for axis in ANGLES] for row in rows], dtype=np.float64)
    off = np.abs((pairs + 180.0) % 360.0 - 180.0).max(axis=1) if len(rows) else np.empty(0)
    off = off[np.isfinite(off)]
    if not off.size:
        return ""
    return f"; the attitude was off by {np.median(off):.3g}° (median), at most {off.max():.3g}° (ATT)"
