"""PX4 ULog: ``vehicle_thrust_setpoint`` and ``vehicle_torque_setpoint`` (library pyulog, extra ``px4``).

PX4's setpoints are normalised: 1 is what the vehicle can do on an axis, not 1 N; ``--scale`` turns them
into newtons. Axes are x forward, y starboard, z down.
"""

from pathlib import Path
from typing import Any

import numpy as np

from alloc.errors import DemandError
from bench.inputs.logs import Log
from bench.inputs.parsers import Instances, parsing, read_ulog

SUFFIXES = (".ulg", ".ulog")
THRUST, TORQUE = "vehicle_thrust_setpoint", "vehicle_torque_setpoint"


def read(path: Path, topic: str) -> Log:
    """One demand a thrust setpoint, with the torque setpoint that held then; none before the first torque.

    The topic is the number of an instance, as a VTOL has one for hovering and one for cruising.
    """
    with parsing(path, "ULog", "pyulog"):
        sets, _, odd = read_ulog(path, THRUST, TORQUE)
        return _chosen(path, sets, topic)._replace(odd=odd)


def _chosen(path: Path, sets: dict[str, Instances], topic: str) -> Log:
    for name in (THRUST, TORQUE):
        if not sets[name]:
            raise DemandError(f"{path}: holds no {name}; log it (SDLOG_PROFILE, default set)")
    logs = {str(i): _log(sets[THRUST][i], sets[TORQUE][i]) for i in sets[THRUST] if i in sets[TORQUE]}
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


def _log(thrust: dict[str, Any], torque: dict[str, Any]) -> Log:
    held = np.searchsorted(torque["timestamp"], thrust["timestamp"], side="right") - 1
    kept = held >= 0
    columns = [np.asarray(thrust[f"xyz[{i}]"], dtype=np.float64)[kept] for i in range(3)]
    columns += [np.asarray(torque[f"xyz[{i}]"], dtype=np.float64)[held[kept]] for i in range(3)]
    times = np.asarray(thrust["timestamp"], dtype=np.int64)[kept]
    start = times[0] if len(times) else 0
    return Log((times - start) / 1e6, np.stack(columns, axis=1), "frd", "as PX4 has it", shares=True)
