"""Failures that nobody announces, on simulated dives: which thruster is named, and how often wrongly.

``python docs/studies/dives.py [DIVES [HOURS]]`` flies so many dives with each shipped vehicle: with random
readiness, healthy, and with one thruster off; then so many healthy hours in C (``dives.c``). Each dive has
the BlueROV2's body, scaled by axis to what the vehicle's thrusters push there, drag that is up to 20 %
other, and a current. Demands wander through what the vehicle can do; the velocity is fed back. Readiness is
estimated from thrusts that were told, measured accelerations and velocities over the ground; the monitor has
the nominal drag, and noise as seen on healthy dives: its standard deviation about its mean, half a second
long. A thruster counts as told in 10 s by its time (``check --failures``), for that noise and the demands of
healthy dives.
"""

import ctypes
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Vehicle, build, generate, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.c.compiled import shared_library
from alloc.c.suspicion import ACCUSED, accusations
from alloc.lint.isolation import isolation
from alloc.vehicle.geometry import DOF
from bench.demands.mission import LINEAR, QUADRATIC, M
from bench.judging.accusation import (
    SOON_S,
    accused_shares,
    largest_demands,
    random_waves,
    seconds_to_accuse,
    wandering_demands,
)
from bench.judging.readiness import (
    VAGUE,
    WINDOW_S,
    WindowReadiness,
    coriolis,
    estimate_readiness,
    neighbour_velocity,
)

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


SAMPLE = 200
"""Healthy dives whose thrusts are the demands that times are told for."""
HEALTHY_S = 300.0
"""Length of a dive in C: memory of a monitor is 51 s at this rate [s]."""


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


def draws(vehicle: Vehicle, rng: np.random.Generator, dives: int, current: float) -> tuple[FloatArray, ...]:
    """Share of the nominal drag, water [m/s] (dives, k), periods and phases of demands (3, dives, k)."""
    drag, drift = rng.uniform(0.8, 1.2, (dives, vehicle.k)), rng.uniform(-1.0, 1.0, (dives, vehicle.k))
    water = current * drift * np.isin(vehicle.dof, DOF[:3])
    return drag, water, *random_waves(rng, dives, vehicle.k)


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
    drag, water, *waves = draws(vehicle, rng, D, current)
    t = np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    demands = wandering_demands(vehicle, (waves[0], waves[1]), t)
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
        wanted = demands[step]
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
    clear = Flight(flight.t[rows], *(each[:, rows] for each in flight[1:]))
    return [WindowReadiness(0.0, seconds, *each).accused for each in estimates(vehicle, clear)]


def estimates(vehicle: Vehicle, flight: Flight) -> list[tuple[FloatArray, FloatArray]]:
    """Readiness (n,) and half-widths (n,) of each dive, as of one window of a log."""
    return [
        estimate_readiness(vehicle, f, a, neighbour_velocity(flight.t, a, v))
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


def noise_of(vehicle: Vehicle, healthy: Flight, size: FloatArray) -> FloatArray:
    """Noise (k,) of the wrenches that healthy dives felt, about the mean of each dive [N, N m]."""
    errors = [each - each.mean(axis=0) for _, each in residuals(vehicle, healthy, size)]
    noise: FloatArray = np.concatenate(errors).std(axis=0)
    return noise


def monitor_accusations(
    vehicle: Vehicle, noise: FloatArray, flight: Flight, size: FloatArray, seconds: float
) -> list[tuple[int, set[int]]]:
    """The monitor's suspect after the first seconds of each dive, and all that it accused in them."""
    rows, found = flight.t < seconds, []
    for f, (felt, _) in zip(flight.f, residuals(vehicle, flight, size), strict=True):
        _, who, odds = accusations(vehicle, noise, f[rows], felt[rows], LASTING_S * RATE_HZ)
        found.append((int(who[-1]), set(who[odds > ACCUSED].tolist())))
    return found


def healthy_dive(vehicle: Vehicle, noise: FloatArray, size: FloatArray) -> Callable[..., float]:
    """Function of drag, water (k,), periods, phases (3, k), noise, steps, seed: it flies a dive in C."""
    mass, linear, quadratic = dynamics(vehicle, size)
    files = generate(vehicle, "scaled", monitor=noise, lasting=LASTING_S * RATE_HZ)
    sources = {name: text for name, text in files.items() if name.endswith((".c", ".h")) and "/" not in name}
    (monitor,) = (name[:-2] for name in sources if name.endswith("_monitor.h"))
    own = monitor.removesuffix("_monitor")

    def listed(values: FloatArray) -> str:
        return f"{{{', '.join(map(repr, values.tolist()))}}}".replace("[", "{").replace("]", "}")

    largest = largest_demands(vehicle)
    numbers = {
        "mass": mass,
        "inverse": 1.0 / mass,
        "linear": linear,
        "quadratic": quadratic,
        "largest": largest,
    }
    sources["vehicle.h"] = "\n".join(
        [
            f'#include "{own}.h"',
            f'#include "{monitor}.h"',
            f"#define K {vehicle.k}",
            f"#define N {vehicle.n}",
            f"#define FINE {FINE}",
            f"#define RATE_HZ {RATE_HZ}",
            f"#define GAIN {GAIN}",
            f"#define ONES {listed(np.ones(vehicle.k))}",
            f"#define STATE struct {monitor}",
            f"#define ALLOCATE(tau, f, share) {own}(tau, -1, f, share)",
            f"#define WATCH {monitor}",
            f"#define SUSPECT {own}_suspect",
            f"static const int axis[K] = {listed(np.array([DOF.index(each) for each in vehicle.dof]))};",
            f"static const double T[K][N] = {listed(vehicle.T)};",
            *(f"static const double {name}[K] = {listed(values)};" for name, values in numbers.items()),
        ]
    )
    sources["dives.c"] = Path(__file__).with_name("dives.c").read_text(encoding="utf-8")
    library = ctypes.CDLL(str(shared_library(f"{own}_dives", sources)))
    array = np.ctypeslib.ndpointer(dtype=np.float64, flags="C")
    library.dive.restype = ctypes.c_double
    library.dive.argtypes = [
        *[array] * 4, ctypes.c_double, ctypes.c_int, ctypes.c_uint64, *[ctypes.c_void_p] * 3
    ]  # fmt: skip

    def dive(*arguments: object, rows: tuple[FloatArray, ...] = ()) -> float:
        """Largest log odds; thrusts, accelerations and velocities go into ``rows``, if given."""
        pointers: list[int | None] = [each.ctypes.data for each in rows] or [None, None, None]
        return float(library.dive(*arguments, *pointers))

    return dive


def healthy_odds(
    vehicle: Vehicle, noise: FloatArray, size: FloatArray, dives: int, rng: np.random.Generator
) -> FloatArray:
    """Largest log odds (dives,) of healthy dives of HEALTHY_S, in C."""
    dive, steps, odds = healthy_dive(vehicle, noise, size), int(HEALTHY_S * RATE_HZ), []
    for _ in range(dives):
        drawn = (each.reshape(-1, vehicle.k) for each in draws(vehicle, rng, 1, CURRENT))
        odds.append(dive(*drawn, NOISE, steps, int(rng.integers(1, 2**62))))
    return np.array(odds)


def of_vehicle(name: str, dives: int, hours: float) -> list[str]:
    """A row of the table."""
    rng, plain = np.random.default_rng(20), load_vehicle(name)
    size = body(plain)
    vehicle = replace(plain, inertia=size * M)
    truth = rng.uniform(0.0, 1.0, (dives, vehicle.n))
    flight = fly(vehicle, rng, truth, current=CURRENT, size=size, gain=GAIN)
    found, half_width = (np.array(each) for each in zip(*estimates(vehicle, flight), strict=True))
    known, narrow, error = half_width < VAGUE, half_width <= 0.1, np.abs(found - truth)
    healthy = fly(vehicle, rng, np.ones((dives, vehicle.n)), current=CURRENT, size=size, gain=GAIN)
    wrongly = sum(map(bool, log_accusations(vehicle, healthy, WINDOW_S)))
    noise = noise_of(vehicle, healthy, size)
    apart = separable(vehicle)
    shares = accused_shares(vehicle, noise, healthy.f[:SAMPLE], LASTING_S * RATE_HZ)
    told = np.flatnonzero(seconds_to_accuse(shares, RATE_HZ) <= SOON_S)
    readiness, off = sole_failures(vehicle, apart, dives)
    cells = ["–"] * 5
    if off:
        flight = fly(vehicle, rng, readiness, current=CURRENT, size=size, gain=GAIN)
        named = [each == [i] for each, i in zip(log_accusations(vehicle, flight, SOON_S), off, strict=True)]
        suspects, sets = zip(*monitor_accusations(vehicle, noise, flight, size, SOON_S), strict=True)
        right = [one == i for one, i in zip(suspects, off, strict=True)]
        accused = np.array([each == {i} for each, i in zip(sets, off, strict=True)])
        foretold = shares[int(SOON_S * RATE_HZ) - 1, off].mean()
        soon = accused[np.isin(off, told)]
        each = [np.mean(named), np.mean(right), foretold, accused.mean()]
        cells = [f"{100 * share:.1f}" for share in each] + [f"{100 * soon.mean():.1f}" if soon.size else "–"]
    odds = healthy_odds(vehicle, noise, size, round(hours * 3600 / HEALTHY_S), rng)
    return [
        name, f"{100 * known.mean():.1f}", f"{100 * (error <= half_width)[known].mean():.1f}",
        f"{100 * (error <= 0.1)[narrow].mean():.1f}",
        f"{len(apart)} of {vehicle.n}", *cells[:4], f"{len(told)}", cells[4], f"{wrongly}",
        f"{(odds > ACCUSED).sum()} in {len(odds) * HEALTHY_S / 3600:.0f} h", f"{odds.max():.1f}",
    ]  # fmt: skip


LOG, MONITOR = (0, 1, 2, 3, 4, 5, 11), (0, 6, 7, 8, 9, 10, 12, 13)
"""Columns of what ``of_vehicle`` finds that belong to the estimate from a log, and to the monitor."""


def main(dives: int, hours: float) -> None:
    """Print a table of the estimate from a log, and one of the monitor; each vehicle on stderr as it ends."""
    header = [
        "vehicle", "readiness known [%]", "truth in the 95 % interval [%]", "within 0.1 [%]",
        "can be told apart", "log names a dead one in 10 s [%]", "right suspect [%]",
        "accused in 10 s, foretold [%]", "accused [%]", "told in 10 s", "of these accused [%]",
        "false accusations", "false accusations", "largest odds of these",
    ]  # fmt: skip
    lines = [header, [":--"] * len(header)]
    for name in list_vehicles():
        lines.append(of_vehicle(name, dives, hours))
        print(*lines[-1], sep=", ", file=sys.stderr, flush=True)
    for title, columns in (("From a log", LOG), ("The monitor", MONITOR)):
        rows = ("| " + " | ".join(line[i] for i in columns) + " |" for line in lines)
        print(f"{title}:", "", *rows, "", sep="\n")


if __name__ == "__main__":
    dives, hours, *_ = [*map(float, sys.argv[1:]), *(150.0, 10.0)[len(sys.argv) - 1 :]]
    main(int(dives), hours)
