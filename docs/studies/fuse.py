"""What a fuse costs: shares of demands and currents of three ways to stay below 20 A, at 12 V.

    python docs/studies/fuse.py [DIRECTIONS]

Demands lie along random thrusts within the limits at 12 V, farther out than these allow. One way holds each
thruster to the n-th part of the cap; `scaled` and `frugal` take the cap in the call. Last comes the energy of
the missions, without a cap.
"""

import sys

import numpy as np

from alloc import Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from bench.judging.cap import missions_power

CAP, VOLTS = 20.0, 12.0
METHODS = ("scaled", "frugal", "cap-by-thruster")
VEHICLES = ("bluerov2", "bluerov2-heavy")
RATIOS = (
    "share of each at cap/n, over `frugal`'s",
    "share of `scaled`, over `frugal`'s",
    "share of `scaled`, over each at cap/n",
    "current of `frugal` for the same wrench, over `scaled`'s",
)


def compared(vehicle: Vehicle, directions: int) -> dict[str, FloatArray]:
    """Ratios (directions,) of shares, and of the currents for one wrench."""
    rng, draw = np.random.default_rng(2004), vehicle.draw(VOLTS)
    low, high = vehicle.limits(volts=VOLTS)
    scaled, frugal, by_thruster = (build(name, vehicle) for name in METHODS)
    rows = []
    for f in rng.uniform(low, high, (directions, vehicle.n)):
        tau = vehicle.strong.TP @ f
        tau = 10.0 * tau / np.abs(tau / vehicle.wrench_scale).max()
        whole = scaled(tau, low, high)
        each = by_thruster(tau, low, high, cap=CAP, volts=VOLTS).share[0]
        under = scaled(tau, low, high, cap=CAP, volts=VOLTS)
        least = frugal(tau, low, high, cap=CAP, volts=VOLTS)
        same = frugal(under.share[0] * tau, low, high, volts=VOLTS)
        assert draw.amps(whole.f).sum() > CAP >= np.sum(under.amps)
        rows.append(
            (
                each / least.share[0],
                under.share[0] / least.share[0],
                under.share[0] / each,
                np.sum(same.amps) / np.sum(under.amps),
            )
        )
    return dict(zip(RATIOS, np.array(rows).T, strict=True))


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 288
    vehicles = [load_vehicle(name) for name in VEHICLES]
    found = [compared(vehicle, count) for vehicle in vehicles]
    for what in RATIOS:
        cells = (
            f"{np.median(each[what]):.2f} ({each[what].min():.2f} … {each[what].max():.2f})" for each in found
        )
        print(f"| {what} | {' | '.join(cells)} |")
    powers = [missions_power(vehicle, VOLTS, 0) for vehicle in vehicles]
    for each in zip(*powers, strict=True):
        print(f"| energy of {each[0].demands} | {' | '.join(power.words for power in each)} |")
