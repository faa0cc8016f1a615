"""Simulated dives: a vehicle flies random demands, with what its log would hold."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.geometry import DOF
from dives import fly


class Dive(NamedTuple):
    """Rows of a dive: times (N,) [s], thrusts told (N, n) [N], accelerations and velocities (N, k) [SI]."""

    t: FloatArray
    f: FloatArray
    a: FloatArray
    v: FloatArray


def dive(
    vehicle: Vehicle,
    rng: np.random.Generator,
    readiness: FloatArray,
    seconds: float = 20.0,
    noise: float = 0.02,
) -> Dive:
    """One dive as the study of failures flies it, on the BlueROV2's body, in still water."""
    flown = fly(vehicle, rng, readiness[None], seconds, noise)
    return Dive(flown.t, *(each[0] for each in flown[1:]))


class SensorLog(NamedTuple):
    """Sensors in the log of a dive: times (S,) [s]; body axes frd, the earth's north, east, down.

    force (S, 3) [m/s^2], rates (S, 3) [rad/s], attitude (S, 4) x, y, z, w, velocity (S, 3) [m/s].
    """

    t: FloatArray
    force: FloatArray
    rates: FloatArray
    attitude: FloatArray
    velocity: FloatArray


def simulate_sensors(flown: Dive, dof: tuple[str, ...], rate_hz: float = 100.0) -> SensorLog:
    """Sensors of a dive that began level towards the south-east, on straight lines between its rows."""
    t = np.arange(flown.t[0], flown.t[-1], 1 / rate_hz)
    which = [DOF.index(axis) for axis in dof]
    six = np.zeros((2, len(t), 6))
    rates = np.diff(flown.v, axis=0) / np.diff(flown.t)[:, None]
    six[0][:, which] = rates[np.searchsorted(flown.t, t + 1e-9) - 1]
    for axis, column in zip(which, flown.v.T, strict=True):
        six[1][:, axis] = np.interp(t, flown.t, column)
    (a, _), (u, w) = (np.hsplit(each, 2) for each in six)
    attitude = [Rotation.from_euler("z", 135.0, degrees=True)]
    for spin in w[:-1]:
        attitude.append(attitude[-1] * Rotation.from_rotvec(spin / rate_hz))
    turning = Rotation.concatenate(attitude)
    force = a + np.cross(w, u) - turning.inv().apply((0.0, 0.0, 9.80665))
    return SensorLog(t, force, w, turning.as_quat(), turning.apply(u))


def write_dive(path: Path, vehicle: Vehicle, flown: Dive) -> Path:
    """A CSV of the dive: t, u0…, a_surge…, v_surge…; thrusts as the commands that make them."""
    u = vehicle.commands(flown.f).u
    header = ["t", *(f"u{i}" for i in range(vehicle.n))]
    header += [f"{letter}_{axis}" for letter in "av" for axis in vehicle.dof]
    table = np.column_stack([flown.t, u, flown.a, flown.v])
    lines = [",".join(f"{value:.9g}" for value in row) for row in table.tolist()]
    path.write_text("\n".join([",".join(header), *lines]) + "\n", encoding="utf-8")
    return path
