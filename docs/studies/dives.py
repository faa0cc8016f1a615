"""Failures that nobody announces, on simulated dives: which thruster is named, and how often wrongly.

``python docs/studies/dives.py [DIVES]`` flies so many dives with each shipped vehicle. Each has the
BlueROV2's body, scaled by axis to what the vehicle's thrusters push there, drag that is up to 20 % other, and
a current. Demands wander through what the vehicle can do; the velocity is fed back. Readiness is estimated
from thrusts that were told, measured accelerations and velocities over the ground; the monitor has the
nominal drag, and noise as seen on healthy dives: its standard deviation about its mean, half a second long.
"""

import sys
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from alloc import Vehicle, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.c.monitor import ACCUSED, accusations
from alloc.lint.isolation import isolation
from alloc.vehicle.geometry import DOF
from bench.demands.mission import LINEAR, QUADRATIC, M
from bench.judging.readiness import WINDOW_S, WindowReadiness, coriolis, estimate_readiness
from bench.results.text import table

RATE_HZ = 20.0
FINE = 5
"""Steps of the simulation between two rows."""
GAIN = 2.0
"""Feedback of the velocity [1/s]: an error of speed is halved in a third of a second."""
NOISE = 0.05
"""White noise of accelerations [m/s^2, rad/s^2]; velocities have a tenth [m/s, rad/s]."""
CURRENT = 0.2
"""Fastest current along each axis [m/s]."""
LASTING_S = 0.5
"""Time for which the monitor takes noise to last [s]; by axis errors of drag last 0.4 to 0.75 s."""
SOON = 10.0
"""Time within which a dead thruster is to be named [s]."""


class Flight(NamedTuple):
    """Rows of D dives: times (N,) [s], thrusts told (D, N, n) [N], measured a and v (D, N, k) [SI]."""

    t: FloatArray
    f: FloatArray
    a: FloatArray
    v: FloatArray


def body(vehicle: Vehicle) -> FloatArray:
    """Size (6,) of a body that suits a vehicle, relative to the BlueROV2 Heavy's [-]; 1 on other axes."""
    heavy, size = load_vehicle("bluerov2-heavy"), np.ones(6)
    for axis, most in zip(vehicle.dof, np.abs(vehicle.T) @ vehicle.f_max, strict=True):
        size[DOF.index(axis)] = most / (np.abs(heavy.T[DOF.index(axis)]) @ heavy.f_max)
    return size


def dynamics(vehicle: Vehicle, size: FloatArray | float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, linear and quadratic drag (k,) of the vehicle's axes, of a body of that size [SI]."""
    which = [DOF.index(axis) for axis in vehicle.dof]
    mass, linear, quadratic = ((size * each)[which] for each in (M, LINEAR, QUADRATIC))
    return mass, linear, quadratic


def fly(
    vehicle: Vehicle,
    rng: np.random.Generator,
    readiness: FloatArray,
    seconds: float = WINDOW_S,
    noise: float = NOISE,
    current: float = 0.0,
    size: FloatArray | float = 1.0,
    gain: float = 0.0,
) -> Flight:
    """Fly D dives with readiness (D, n), drag up to 20 % other, and a ``current`` along each axis [m/s].

    With a ``gain`` [1/s] the measured velocity is fed back, towards that of the nominal vehicle.
    """
    D, k = len(readiness), vehicle.k
    mass, linear, quadratic = dynamics(vehicle, size)
    drag = rng.uniform(0.8, 1.2, (D, k))
    water = current * rng.uniform(-1.0, 1.0, (D, k)) * np.isin(vehicle.dof, DOF[:3])
    largest = 0.4 * np.abs(vehicle.T) @ vehicle.f_max
    periods, phases = rng.uniform(1.5, 8.0, (3, D, k)), rng.uniform(0, 2 * np.pi, (3, D, k))
    t = np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    waves = np.sin(2 * np.pi * t[:, None, None, None] / periods + phases).mean(axis=1)
    noises = noise * rng.normal(size=(2, len(t), D, k)) * np.array([1.0, 0.1])[:, None, None, None]
    allocate = build("scaled", vehicle)
    f = np.zeros((len(t), D, vehicle.n))
    v, nominal = np.zeros((2, D, k))
    a, seen = np.zeros((2, len(t), D, k))

    def rate(
        wrench: FloatArray, v: FloatArray, drag: FloatArray | float, water: FloatArray | float
    ) -> FloatArray:
        through = v - water
        damping = (linear + quadratic * np.abs(through)) * through
        moved: FloatArray = (wrench - coriolis(vehicle, mass, v) - drag * damping) / mass
        return moved

    for step in range(len(t)):
        seen[step] = v + noises[1, step]
        wanted = largest * waves[step]
        f[step], _ = allocate.many(wanted + gain * mass * (nominal - seen[step]))
        wrench = (readiness * f[step]) @ vehicle.T.T
        a[step] = rate(wrench, v, drag, water) + noises[0, step]
        for _ in range(FINE):
            v = v + rate(wrench, v, drag, water) / (RATE_HZ * FINE)
            nominal = nominal + rate(wanted, nominal, 1.0, 0.0) / (RATE_HZ * FINE)
    return Flight(t, *(np.swapaxes(each, 0, 1) for each in (f, a, seen)))


def separable(vehicle: Vehicle) -> list[int]:
    """Thrusters whose failure shows, and looks like that of no other."""
    found = isolation(vehicle)
    alike = {name for first, second, _ in found.alike for name in (first, second)}
    return [i for i in range(vehicle.n) if vehicle.called(i) not in alike and found.shows[i].loss <= 1.0]


def sole_failures(vehicle: Vehicle, apart: list[int], dives: int) -> tuple[FloatArray, list[int]]:
    """Readiness (dives, n) with one of the thrusters ``apart`` off in each, and which."""
    off = [apart[each % len(apart)] for each in range(dives)] if apart else []
    readiness = np.ones((len(off), vehicle.n))
    readiness[range(len(off)), off] = 0.0
    return readiness, off


def log_accusations(vehicle: Vehicle, flight: Flight, seconds: float) -> list[list[int]]:
    """Thrusters that the estimate of the first seconds of each dive accuses."""
    rows = flight.t < seconds
    return [
        WindowReadiness(0.0, seconds, *estimate_readiness(vehicle, f[rows], a[rows], v[rows])).accused
        for f, a, v in zip(*flight[1:], strict=True)
    ]


def residuals(vehicle: Vehicle, flight: Flight, size: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Wrenches (N, k) that each dive felt by the nominal drag, and T f less these."""
    mass, linear, quadratic = dynamics(vehicle, size)
    felt = [
        mass * a + coriolis(vehicle, mass, v) + (linear + quadratic * np.abs(v)) * v
        for a, v in zip(flight.a, flight.v, strict=True)
    ]
    return [(each, f @ vehicle.T.T - each) for f, each in zip(flight.f, felt, strict=True)]


def monitor_accusations(
    vehicle: Vehicle, noise: FloatArray, flight: Flight, size: FloatArray, seconds: float
) -> list[tuple[int, set[int]]]:
    """The monitor's suspect after the first seconds of each dive, and all that it accused in them."""
    rows, found = flight.t < seconds, []
    for f, (felt, _) in zip(flight.f, residuals(vehicle, flight, size), strict=True):
        _, who, odds = accusations(vehicle, noise, f[rows], felt[rows], LASTING_S * RATE_HZ)
        found.append((int(who[-1]), set(who[odds > ACCUSED].tolist())))
    return found


def of_vehicle(name: str, dives: int) -> list[str]:
    """A row of the table."""
    rng, plain = np.random.default_rng(20), load_vehicle(name)
    size = body(plain)
    vehicle = replace(plain, inertia=size * M)
    truth = rng.uniform(0.0, 1.0, (dives, vehicle.n))
    flight = fly(vehicle, rng, truth, current=CURRENT, size=size, gain=GAIN)
    inside, near = [], []
    for p, *rows in zip(truth, *flight[1:], strict=True):
        estimate, half_width = estimate_readiness(vehicle, *rows)
        known = np.isfinite(half_width)
        inside += (np.abs(estimate - p) <= half_width)[known].tolist()
        near += (np.abs(estimate - p) <= 0.1)[known].tolist()
    healthy = fly(vehicle, rng, np.ones((dives, vehicle.n)), current=CURRENT, size=size, gain=GAIN)
    wrongly = sum(map(bool, log_accusations(vehicle, healthy, WINDOW_S)))
    errors = [each - each.mean(axis=0) for _, each in residuals(vehicle, healthy, size)]
    noise = np.concatenate(errors).std(axis=0)
    cried = sum(bool(each) for _, each in monitor_accusations(vehicle, noise, healthy, size, WINDOW_S))
    apart = separable(vehicle)
    readiness, off = sole_failures(vehicle, apart, dives)
    shares = ["–"] * 3
    if off:
        flight = fly(vehicle, rng, readiness, current=CURRENT, size=size, gain=GAIN)
        named = [each == [i] for each, i in zip(log_accusations(vehicle, flight, SOON), off, strict=True)]
        suspects, sets = zip(*monitor_accusations(vehicle, noise, flight, size, SOON), strict=True)
        seen = [[one == i for one, i in zip(suspects, off, strict=True)]]
        seen += [[each == {i} for each, i in zip(sets, off, strict=True)]]
        shares = [f"{100 * np.mean(each):.1f}" for each in (named, *seen)]
    hours = f"{dives * WINDOW_S / 3600:.2f}"
    return [
        name, f"{100 * np.mean(inside):.1f}", f"{100 * np.mean(near):.1f}",
        f"{len(apart)} of {vehicle.n}", *shares, f"{wrongly}, {cried}", hours,
    ]  # fmt: skip


def main(dives: int) -> None:
    """Print the table."""
    header = [
        "vehicle", "truth in the 95 % interval [%]", "within 0.1 [%]", "can be told apart",
        "dead one named in 10 s [%]", "monitor: right suspect [%]", "accused [%]",
        "false accusations: log, monitor", "hours",
    ]  # fmt: skip
    print(table(header, [of_vehicle(name, dives) for name in list_vehicles()]))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 150)
