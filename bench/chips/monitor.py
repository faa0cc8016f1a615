"""Counts the C that accuses thrusters, on processors that are emulated."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.c import Target, accusations, monitor
from alloc.lint.isolation import assumed_noise
from alloc.methods import recipe
from alloc.program import Faults, Scalar, Where
from bench.chips.call_sets import count_sets
from bench.chips.count import CallCounts
from bench.chips.kernels import Kernel
from bench.chips.processors import Processor
from bench.record import Emulated

METHOD = "monitor"
"""Name in tables, and for ``thrustbench emulate --method``."""
BEHIND = "pinv"
"""The method beside whose C it stands; its instructions are not counted."""
SETS = {"whole": 1.0, "half-strength": 0.5}
"""Readiness of the first thruster in each set [-]."""
ROUNDING = 1e-2
"""Most that rounding to float moves log odds, relative to them or to 1 [-]."""


def kernel(vehicle: Vehicle, scalar: Scalar, limits: Where, faults: Faults = "one") -> Kernel:
    """NAME_monitor as a kernel whose demand is f and the wrench.

    Its first thrust is the log odds that NAME_suspect says just before the call.
    """
    target = Target(vehicle=vehicle, method=recipe(BEHIND), scalar=scalar, limits=limits, faults=faults)
    name, n = f"{target.name}_monitor", vehicle.n
    return Kernel(
        method=METHOD,
        twin="",
        scalar=scalar,
        k=n + vehicle.k,
        n=n,
        entry=name,
        declaration=f"""\
#include "{name}.h"
static struct {name} state;
static struct {name} *asked({scalar} *f)
{{
    (void){target.name}_suspect(&state, f);
    return &state;
}}""",
        arguments=f"asked(f), tau, tau + {n}",
        sources=monitor(target, assumed_noise(vehicle)),
    )


def calls(vehicle: Vehicle, n: int, seed: int) -> dict[str, FloatArray]:
    """Calls (n, n + k) of each set: random thrusts within limits, and the wrench with the assumed noise."""
    rng, made = np.random.default_rng(seed), {}
    for name, readiness in SETS.items():
        F = rng.uniform(vehicle.f_min, vehicle.f_max, (n, vehicle.n))
        pushed = F.copy()
        pushed[:, vehicle.working[0]] *= readiness
        noise = assumed_noise(vehicle) * rng.normal(size=(n, vehicle.k))
        made[name] = np.hstack([F, pushed @ vehicle.TP.T + noise])
    return made


def rows(row: Emulated, made: Kernel, vehicle: Vehicle, processor: Processor, n: int) -> Iterator[Emulated]:
    """A row for each set of n calls; raises as ``link`` of an image."""
    yield from count_sets(
        row, made, processor, calls(vehicle, n, row.seed), partial(agreement, vehicle, made.scalar)
    )


def agreement(vehicle: Vehicle, scalar: Scalar, asked: FloatArray, counted: CallCounts) -> tuple[bool, float]:
    """True if answers to calls (N, n + k) are Python's, and the largest error of log odds, over 1 + these."""
    noise, n = assumed_noise(vehicle), vehicle.n
    status, _, odds = accusations(vehicle, noise, asked[:, :n], asked[:, n:], scalar=scalar)
    before = np.append(0.0, odds[:-1])
    apart = np.abs(counted.F[:, 0] - before) / (1.0 + before)
    return bool((counted.status == status).all() and (apart <= ROUNDING).all()), float(apart.max())
