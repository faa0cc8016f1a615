"""What exactness costs in C on this machine: ``nullspace`` over ``clip``, both of which keep the limits.

``python -m bench.studies.clip_price [VEHICLE …]`` prints a table: this project's ``nullspace`` and ``clip``,
and ``clip`` as one writes it by hand, a product and two compares a thrust, which does not look whether its
arguments are finite nor say whether the demand is met. The kernels take turns; each figure is the least of
all repeats, CPU time, over inactive, active and infeasible demands in equal parts.
"""

import argparse

import numpy as np

from alloc import Vehicle, build, load_vehicle
from alloc.native.code import number
from bench.emulation.kernel import Kernel
from bench.emulation.kernels import build_kernel
from bench.studies.c_loop import nanoseconds
from bench.studies.native_speed import demands

VEHICLES = ("ukwial", "bluerov2", "bluerov2-heavy", "nautilus", "subjugator8")
ROUNDS = 6


def by_hand(vehicle: Vehicle) -> Kernel:
    """f = T* tau, each thrust cut at its limits: what a few minutes of work give."""
    G = build("pinv", vehicle).many(np.eye(vehicle.k))[0].T
    keep = np.abs(G) > 1e-14 * np.abs(G).max()  # smaller entries are rounding
    lines = []
    for i in range(vehicle.n):
        terms = (f"{number(G[i, j], 'double')} * tau[{j}]" for j in np.flatnonzero(keep[i]))
        low, high = (number(side[i], "double") for side in (vehicle.f_min, vehicle.f_max))
        lines.append(
            f"    const double x{i} = {' + '.join(terms) or '0.0'};\n"
            f"    f[{i}] = x{i} < {low} ? {low} : x{i} > {high} ? {high} : x{i};\n"
        )
    name = "clip_by_hand"
    declaration = f"int {name}(const double *tau, double *f)"
    return Kernel(
        method=name,
        twin="clip",
        scalar="double",
        k=vehicle.k,
        n=vehicle.n,
        entry=name,
        declaration=f"{declaration};",
        arguments="tau, f",
        sources={f"{name}.c": f"{declaration};\n{declaration}\n{{\n{''.join(lines)}    return 0;\n}}\n"},
    )


def measure(vehicle: Vehicle) -> dict[str, float]:
    """Least time of a call [ns] of each kernel."""
    kernels = {name: build_kernel(f"{name}@native", vehicle, "double") for name in ("nullspace", "clip")}
    kernels["by hand"] = by_hand(vehicle)
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
