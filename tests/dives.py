"""Simulated dives: a vehicle flies random demands, with what its log would hold."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Vehicle, build
from alloc.allocation import FloatArray
from alloc.vehicle.geometry import DOF
from bench.demands.mission import LINEAR, QUADRATIC, M, resistance

RATE_HZ = 20.0
FINE = 5
"""Steps of the simulation between two rows."""


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
    """Demands that wander through what the vehicle can do, on the BlueROV2's body; drag is up to 20 % other.

    Measured accelerations have white ``noise`` [m/s^2, rad/s^2], velocities a tenth of it.
    """
    which = [DOF.index(axis) for axis in vehicle.dof]
    other = rng.uniform(0.8, 1.2, 6)
    allocate = build("scaled", vehicle)
    steps = int(seconds * RATE_HZ)
    size = 0.4 * np.abs(vehicle.T) @ vehicle.f_max
    periods, phases = rng.uniform(1.5, 8.0, (3, vehicle.k)), rng.uniform(0, 2 * np.pi, (3, vehicle.k))
    v, rows = np.zeros(6), []
    dt = 1 / (RATE_HZ * FINE)
    for step in range(steps):
        waves = np.sin(2 * np.pi * step / RATE_HZ / periods + phases).mean(axis=0)
        f = allocate(size * waves).f
        wrench = np.zeros(6)
        wrench[which] = vehicle.T @ (readiness * f)
        damping = (LINEAR + QUADRATIC * np.abs(v)) * v
        # The other drag changes what the vehicle does, not what is known of its mass.
        a = (wrench - resistance(v) - (other - 1.0) * damping) / M
        a[[i for i in range(6) if i not in which]] = 0.0
        rows.append((step / RATE_HZ, f, a[which].copy(), v[which].copy()))
        for _ in range(FINE):
            damping = (LINEAR + QUADRATIC * np.abs(v)) * v
            rate = (wrench - resistance(v) - (other - 1.0) * damping) / M
            v[which] = (v + dt * rate)[which]
    t, f, a, v = (np.array(column) for column in zip(*rows, strict=True))
    return Dive(t, f, a + noise * rng.normal(size=a.shape), v + 0.1 * noise * rng.normal(size=v.shape))


def write_dive(path: Path, vehicle: Vehicle, flown: Dive) -> Path:
    """A CSV of the dive: t, u0…, a_surge…, v_surge…; thrusts as the commands that make them."""
    u = vehicle.commands(flown.f).u
    header = ["t", *(f"u{i}" for i in range(vehicle.n))]
    header += [f"{letter}_{axis}" for letter in "av" for axis in vehicle.dof]
    table = np.column_stack([flown.t, u, flown.a, flown.v])
    lines = [",".join(f"{value:.9g}" for value in row) for row in table.tolist()]
    path.write_text("\n".join([",".join(header), *lines]) + "\n", encoding="utf-8")
    return path
