"""Weighted least squares: steps, times beside solvers, and the price of gamma; the numbers of docs/soft.md.

``python docs/studies/soft.py steps [DEMANDS]`` counts the steps of the method ``soft`` for so many demands of
each shipped vehicle, whole and with a thruster off, within its limits and within others. ``times`` has what a
call takes, ``soft@native`` and others in turns, as ratios within one run. ``gamma [VEHICLE]`` has what a
weight of effort costs of the wrench, and what it saves of the thrust.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from alloc import Allocator, Status, Vehicle, build, catalogue, list_vehicles, load_vehicle
from alloc.allocation import BoundedSteps, FloatArray
from bench.chips.kernels import build_kernel
from bench.demands import build_demands
from bench.results.text import table, three
from c_loop import nanoseconds
from native_speed import interleaved

SIZES = (0.5, 1.0, 2.0, 5.0, 30.0)
"""Demands in units of what random thrusts inside the limits make."""
CLASSES = ("inactive", "active", "infeasible")
PER_CLASS = 100
SOLVERS = ("qp-soft/daqp", "qp-soft/quadprog", "qp-soft/piqp", "qp-soft/osqp")
GAMMAS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
"""Prices of effort, of thrusts over the largest limit, where a wrench that is missed costs one."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """Wrenches (n, k) of thrusts inside the limits and beyond, and wrenches of any direction."""
    size = rng.choice(SIZES, (n, 1))
    made = size * rng.uniform(vehicle.f_min, vehicle.f_max, (n, vehicle.n)) @ vehicle.TP.T
    any_way = size * rng.normal(size=(n, vehicle.k)) * vehicle.wrench_scale
    taus: FloatArray = np.where(rng.random((n, 1)) < 0.3, any_way, made)
    return taus


def counted(vehicle: Vehicle, rng: np.random.Generator, n: int) -> tuple[float, int, int, int]:
    """Mean and most steps of n demands, the most that a call may take, and demands without an answer."""
    allocate = build("soft", vehicle)
    assert isinstance(allocate, BoundedSteps)
    steps, unanswered = [], 0
    for tau, own in zip(demands(vehicle, rng, n), rng.random(n) < 0.5, strict=True):
        ends = np.sort(rng.uniform(vehicle.f_min, vehicle.f_max, (2, vehicle.n)), axis=0)
        found = allocate(tau, *(() if own else ends))
        steps.append(found.iterations)
        unanswered += found.status is Status.NOT_CONVERGED
    return float(np.mean(steps)), max(steps), allocate.worst_case_steps or 0, unanswered


def count_steps(n: int) -> str:
    """A row for each vehicle."""
    rows = []
    for name in list_vehicles():
        rng, whole = np.random.default_rng(11), load_vehicle(name)
        for vehicle, each in ((whole, n // 2), (whole.with_fault(0), n // 2)):
            mean, most, bound, unanswered = counted(vehicle, rng, each)
            off = "1 off" if vehicle is not whole else "whole"
            rows.append([name, off, f"{each:,}", f"{mean:.2f}", f"{most}", f"{bound}", f"{unanswered}"])
    return table(["vehicle", "", "demands", "mean steps", "most", "bound", "without an answer"], rows)


def calls(vehicle: Vehicle) -> dict[str, Callable[[FloatArray], object]]:
    """Allocators by name: this project's and the solvers' that are installed."""
    known = {entry.name for entry in catalogue() if not entry.missing}
    made: dict[str, Allocator] = {}
    for name in ("soft@native", "nullspace@native", "soft", *SOLVERS):
        if name in known:
            made[name] = build(name, vehicle)
    return dict(made)


def compare_times(rounds: int) -> str:
    """Time of a call from Python over that of ``soft@native``, and that one's own C [ns], by vehicle."""
    rows, columns = list[list[str]](), list[str]()
    for name in list_vehicles():
        vehicle = load_vehicle(name)
        taus = np.vstack([build_demands(each, vehicle, 0, PER_CLASS).taus for each in CLASSES])
        taus = np.random.default_rng(0).permutation(taus)
        times = interleaved(calls(vehicle), taus, rounds)
        own = {
            method: float(nanoseconds(build_kernel(method, vehicle, "double"), taus, rounds).min())
            for method in ("soft@native", "scaled@native")
        }
        columns = list(times)
        ratios = [f"{times[each] / times['soft@native']:.2f}" for each in columns]
        rows.append([name, *ratios, *(f"{each:.0f}" for each in own.values())])
    return table(["vehicle", *columns, "C [ns]", "scaled, C [ns]"], rows)


def price(name: str) -> str:
    """Share of the wrench that a weight of effort costs, and of the effort that it saves, by weight."""
    whole = load_vehicle(name)
    rows = []
    for gamma in GAMMAS:
        # Thrusts over f_scale, wrenches over wrench_scale: gamma |f|^2 + |W (T f - tau)|^2.
        vehicle = replace(
            whole,
            H=np.eye(whole.n) * gamma / whole.f_scale**2,
            slack_weights=1.0 / whole.wrench_scale**2,
        )
        allocate, exact = build("soft", vehicle), build("nullspace", whole)
        cells = [f"{gamma:g}"]
        for kind in ("active", "infeasible"):
            taus = build_demands(kind, whole, 0, PER_CLASS).taus
            F = allocate.many(taus)[0]
            missed = np.abs(F @ whole.TP.T - taus) / whole.wrench_scale
            cells.append(three(100 * float(np.median(missed.max(axis=1)))))
            if kind == "active":
                least = exact.many(taus)[0]
                cells.append(three(100 * float(1 - np.median((F**2).sum(axis=1) / (least**2).sum(axis=1)))))
        rows.append(cells)
    heads = ["gamma", "active: missed [%]", "effort saved [%]", "infeasible: missed [%]"]
    return table(heads, rows)


def main() -> None:
    """Print one of the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("steps", "times", "gamma"))
    parser.add_argument("of", nargs="?", help="demands for each vehicle, rounds of times, or a vehicle")
    given = parser.parse_args()
    if given.what == "steps":
        print(count_steps(int(given.of or 150_000)))
    elif given.what == "times":
        print(compare_times(int(given.of or 15)))
    else:
        print(price(given.of or "bluerov2-heavy"))


if __name__ == "__main__":
    main()
