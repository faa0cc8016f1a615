"""PX4 ULog: ``vehicle_thrust_setpoint`` and ``vehicle_torque_setpoint`` (library pyulog, extra ``px4``).

PX4's setpoints are normalised: 1 is what the vehicle can do on an axis, not 1 N; ``--scale`` turns them
into newtons. Axes are x forward, y starboard, z down.
"""

from pathlib import Path
from typing import Any

import numpy as np

from alloc.errors import DemandError
from bench.inputs.logs import Log
from bench.inputs.parsers import parsing, read_ulog

SUFFIXES = (".ulg", ".ulog")
THRUST, TORQUE = "vehicle_thrust_setpoint", "vehicle_torque_setpoint"


def read(path: Path, topic: str) -> Log:
    """One demand a thrust setpoint, with the torque setpoint that held then; none before the first torque."""
    if topic:
        raise DemandError(f"{path}: a ULog's demands are {THRUST} and {TORQUE}; leave out {topic!r}")
    with parsing(path, "ULog", "pyulog"):
        sets, _, odd = read_ulog(path, THRUST, TORQUE)
        return _log(path, sets)._replace(odd=odd)


def _log(path: Path, sets: dict[str, dict[str, Any]]) -> Log:
    for name in (THRUST, TORQUE):
        if name not in sets or not len(sets[name]["timestamp"]):
            raise DemandError(f"{path}: holds no {name}; log it (SDLOG_PROFILE, default set)")
    thrust, torque = sets[THRUST], sets[TORQUE]
    held = np.searchsorted(torque["timestamp"], thrust["timestamp"], side="right") - 1
    kept = held >= 0
    columns = [np.asarray(thrust[f"xyz[{i}]"], dtype=np.float64)[kept] for i in range(3)]
    columns += [np.asarray(torque[f"xyz[{i}]"], dtype=np.float64)[held[kept]] for i in range(3)]
    times = np.asarray(thrust["timestamp"], dtype=np.int64)[kept]
    start = times[0] if len(times) else 0
    return Log((times - start) / 1e6, np.stack(columns, axis=1), "frd", "as PX4 has it", shares=True)
