"""What exactness costs in C on this machine: ``nullspace`` over ``clip``, both of which keep the limits.

``python docs/studies/clip_price.py [VEHICLE …]`` prints a table: this project's ``nullspace`` and ``clip``,
and ``clip`` as one writes it by hand, a product and two compares a thrust, which does not look whether its
arguments are finite nor say whether the demand is met. The kernels take turns; each figure is the least of
all repeats, CPU time, over inactive, active and infeasible demands in equal parts.
"""

import argparse

import numpy as np

import by_hand
from alloc import Vehicle, load_vehicle
from bench.chips.kernels import build_kernel
from c_loop import nanoseconds
from native_speed import demands

VEHICLES = ("ukwial", "bluerov2", "bluerov2-heavy", "nautilus", "subjugator8")
ROUNDS = 6


def measure(vehicle: Vehicle) -> dict[str, float]:
    """Least time of a call [ns] of each kernel."""
    kernels = {name: build_kernel(f"{name}@native", vehicle, "double") for name in ("nullspace", "clip")}
    kernels["by hand"] = by_hand.clip(vehicle)
    taus = demands(vehicle)
    least = dict.fromkeys(kernels, np.inf)
    for _ in range(ROUNDS):
        for name, kernel in kernels.items():
            least[name] = min(least[name], float(nanoseconds(kernel, taus, 5).min()))
    return least


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("vehicles", nargs="*", default=VEHICLES)
    print("| vehicle | nullspace | clip | clip by hand | nullspace / clip | nullspace / by hand |")
    print("|---|---|---|---|---|---|")
    for name in parser.parse_args().vehicles:
        ns = measure(load_vehicle(name))
        exact, clip, hand = ns["nullspace"], ns["clip"], ns["by hand"]
        times = f"{exact:.2f} | {clip:.2f} | {hand:.2f}"
        print(f"| {name} | {times} | {exact / clip:.2f} | {exact / hand:.2f} |", flush=True)


if __name__ == "__main__":
    main()
