"""Counts the C that keeps currents below a cap, on processors that are emulated."""

from collections.abc import Iterator

import numpy as np

from alloc import Vehicle, build
from alloc.allocation import FloatArray
from alloc.c import Target, capped, sources
from alloc.c.cap import ROUNDING
from alloc.methods import recipe
from alloc.program import Faults, Scalar, Where
from bench.chips.call_sets import count_sets
from bench.chips.count import CallCounts
from bench.chips.kernels import Kernel
from bench.chips.processors import Processor
from bench.record import Emulated

METHOD = "cap"
"""Name in tables, and for ``thrustbench emulate --method``."""
BEHIND = "scaled"
"""The method whose C it calls; its instructions are counted, too."""
SETS = {"before-limits": 0.05, "at-limits": 0.5, "all-currents": 1.0}
"""Largest cap in each set, of what all thrusters draw at their limits [-]."""


def kernel(vehicle: Vehicle, scalar: Scalar, limits: Where, faults: Faults = "one") -> Kernel:
    """NAME_cap as a kernel whose demand is tau, cap and volts, then the limits where a call has them."""
    target = Target(vehicle=vehicle, method=recipe(BEHIND), scalar=scalar, limits=limits, faults=faults)
    n, k, at_call = vehicle.n, vehicle.k, limits == "call"
    sides = f"tau + {k + 2}, tau + {k + 2 + n}, " * at_call
    return Kernel(
        method=METHOD,
        twin="",
        scalar=scalar,
        k=k + 2 + 2 * n * at_call,
        n=n,
        levels=1,
        entry=f"{target.name}_cap",
        declaration=f'#include "{target.name}_cap.h"',
        arguments=f"tau, {sides}-1, tau[{k}], tau[{k + 1}], f, share",
        sources=sources(target) | capped(target),
    )


def calls(vehicle: Vehicle, limits: Where, n: int, seed: int) -> dict[str, FloatArray]:
    """Calls of each set: demands up to twice as large as thrusters make, caps, and the nominal voltage."""
    rng, made = np.random.default_rng(seed), {}
    low, high = vehicle.f_min, vehicle.f_max
    most = vehicle.draw().largest(low, high)
    volts = vehicle.cap.volts if vehicle.cap and vehicle.cap.volts else 12.0
    for name, part in SETS.items():
        taus = rng.uniform(0.2, 2.0, (n, 1)) * (rng.uniform(low, high, (n, vehicle.n)) @ vehicle.TP.T)
        supply = np.column_stack([part * most * rng.uniform(0.02, 1.0, n), np.full(n, volts)])
        sides = [np.tile(side, (n, 1)) for side in (low, high)] if limits == "call" else []
        made[name] = np.hstack([taus, supply, *sides])
    return made


def rows(row: Emulated, made: Kernel, vehicle: Vehicle, processor: Processor, n: int) -> Iterator[Emulated]:
    """A row for each set of n calls; raises as ``link`` of an image."""
    sets = calls(vehicle, "call" if row.limits == "call" else "fixed", n, row.seed)
    allocate, k = build(BEHIND, vehicle), vehicle.k
    allowed = ROUNDING["float" if row.scalar == "float" else "double"]

    def agreement(asked: FloatArray, counted: CallCounts) -> tuple[bool, float]:
        answers = [allocate(one[:k], cap=one[k], volts=one[k + 1]) for one in asked]
        apart = np.abs(counted.shares[:, 0] - [one.share[0] for one in answers])
        same = bool((counted.status == [one.status for one in answers]).all())
        return same and bool((apart <= allowed).all()), float(apart.max())

    yield from count_sets(row, made, processor, sets, agreement)
