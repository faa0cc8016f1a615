"""Count every kernel on every processor over every class of demands, and say what could not be counted."""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import msgspec
import numpy as np

from alloc import FloatArray, IndexArray, NotApplicable, Vehicle
from alloc.native.code import Scalar
from bench.demands import DemandSet, build_demands, labelled
from bench.emulation import search
from bench.emulation.agreement import agreement
from bench.emulation.count import CallCounts, count
from bench.emulation.image import Image, link
from bench.emulation.kernel import Kernel
from bench.emulation.kernels import build_kernel, check
from bench.emulation.toolchain import Target, ToolError, missing, versions
from bench.harness import machine
from bench.record import Emulated

CLASSES = ("inactive", "active", "boundary", "infeasible", "mission")
SEARCH = "search"
OSQP_SHARE = 0.1
"""An iterative solver takes a thousand times the instructions: fewer demands off a path, and no search."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What to count: every combination.

    demands : names of sets that every vehicle is asked; the search for the most costly comes on top
    n : demands of each set
    """

    vehicles: tuple[Vehicle, ...]
    targets: tuple[Target, ...]
    methods: tuple[str, ...]
    scalars: tuple[Scalar, ...]
    demands: tuple[str, ...]
    seed: int
    n: int


def emulate(plan: Plan) -> Iterator[Emulated]:
    """The rows, one after the other as they are counted; the same plan gives the same rows.

    Raises UnknownName or DemandError at once, before anything is counted.
    """
    for method in plan.methods:
        check(method)
    return _rows(plan, [(vehicle, _sets(vehicle, plan)) for vehicle in plan.vehicles])


def _rows(plan: Plan, asked: list[tuple[Vehicle, list[DemandSet]]]) -> Iterator[Emulated]:
    reasons = {target: missing(target) for target in plan.targets}
    source = {"thrustbench": machine.commit()}  # a row that is added to a record has its own
    tools = {target: versions(target) | source for target, reason in reasons.items() if not reason}
    for (vehicle, sets), method, scalar, target in product(asked, plan.methods, plan.scalars, plan.targets):
        row = Emulated(vehicle.name, target.name, method, scalar, seed=plan.seed)
        if target not in tools:
            yield msgspec.structs.replace(row, status="missing", reason=reasons[target])
            continue
        row = msgspec.structs.replace(row, tools=tools[target])
        try:
            yield from _one(row, build_kernel(method, vehicle, scalar), target, sets)
        except NotApplicable as refusal:
            yield msgspec.structs.replace(row, status="refused", reason=str(refusal))
        except ToolError as failure:
            yield msgspec.structs.replace(row, status="failed", reason=str(failure))


def _one(row: Emulated, kernel: Kernel, target: Target, sets: list[DemandSet]) -> Iterator[Emulated]:
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(kernel, target, Path(folder))
        row = msgspec.structs.replace(
            row, solver=kernel.solver, flash_bytes=image.flash_bytes, ram_static_bytes=image.ram_static_bytes
        )
        for demands in sets:
            drawn = demands.rate_hz is None
            some = _first(demands, OSQP_SHARE) if drawn and kernel.solver else demands
            yield _counted(row, some, kernel, count(image, some.taus))
        if not kernel.solver and sets:
            tried = _search(image, sets, row.seed)
            found = _counted(row, tried, kernel, count(image, tried.taus))
            # How the other demands were spread says how the search went, and nothing about the kernel.
            yield msgspec.structs.replace(found, tried=len(tried.taus), instructions=found.instructions[-1:])


def _sets(vehicle: Vehicle, plan: Plan) -> list[DemandSet]:
    found = []
    for name in plan.demands:
        try:
            found.append(build_demands(name, vehicle, plan.seed, plan.n))
        except NotApplicable:  # no demand of this class exists for this vehicle
            continue
    return found


def _first(demands: DemandSet, share: float) -> DemandSet:
    few = max(1, round(len(demands.taus) * share))
    return labelled(demands.name, demands.vehicle, demands.taus[:few].copy())


def _search(image: Image, sets: list[DemandSet], seed: int) -> DemandSet:
    vehicle = sets[0].vehicle

    def cost(taus: FloatArray) -> IndexArray:
        return count(image, taus).instructions

    start = np.concatenate([demands.taus[: search.SIZE // len(sets)] for demands in sets])
    taus, _ = search.climb(cost, start, vehicle.wrench_scale, np.random.default_rng(seed))
    return labelled(SEARCH, vehicle, taus)


def _counted(row: Emulated, demands: DemandSet, kernel: Kernel, counted: CallCounts) -> Emulated:
    agreed = agreement(kernel, demands, counted)
    values, calls = np.unique(counted.instructions, return_counts=True)
    return msgspec.structs.replace(
        row,
        demands=demands.name,
        instructions=list(zip(values.tolist(), calls.tolist(), strict=True)),
        worst=demands.taus[int(counted.instructions.argmax())].tolist(),
        stack_bytes=int(counted.stack_bytes.max()),
        agrees=agreed.agrees,
        distance_rel_max=agreed.distance_rel_max,
        other_verdicts=agreed.other_verdicts,
    )
