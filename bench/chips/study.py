"""Counts of every kernel on every processor over every class of demands, as rows of a record."""

import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import msgspec
import numpy as np

from alloc import NotApplicable, Status, Vehicle
from alloc.allocation import FloatArray, IndexArray
from alloc.errors import NotInstalled
from alloc.program import Faults, Scalar, Where
from bench.chips import cap, esc, foreign, monitor, search
from bench.chips.agreement import agreement
from bench.chips.bounds import Unbounded, bound, least_instructions
from bench.chips.count import CallCounts, count
from bench.chips.cycles import cycles
from bench.chips.image import Image, link
from bench.chips.kernels import SCALARS, Kernel, build_kernel, check
from bench.chips.processors import Processor
from bench.chips.toolchain import ToolError, missing, versions
from bench.demands import DemandSet, build_demands, labelled
from bench.demands.corners import extremes
from bench.harness import machine
from bench.harness.lines import new_header
from bench.judging.judge import rounded
from bench.judging.loss import direction_error_deg, relative_wrench_error, share_along
from bench.record import SERVED_WITHIN, Emulated, Header
from bench.record.file import Writer

CLASSES = ("inactive", "active", "boundary", "infeasible", "mission", "jolts")
BESIDE = {cap.METHOD: cap, esc.METHOD: esc, monitor.METHOD: monitor}
"""C beside that of a method, which is counted on calls of its own."""
SEARCH = "search"
EXTREMES = 200
"""Extreme demands of each kind: about the attainable set's edge, far outside, overflowing or NaN."""
RIVALS_SHARE = 0.1
"""Share of each set that a solver's C is asked: it takes up to a hundred thousand times the instructions.
Its most costly demand is not searched for either."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Plan:
    """Plan of a count: every combination of vehicle, method, scalar and processor.

    Attributes
    ----------
    vehicles, processors, methods, scalars, limits : what is combined; methods by name
    faults : which the C knows
    demands : names of the sets that every vehicle is asked, before the search for the most costly demand
    seed : of demands and search
    n : demands of each set
    theirs : an allocator of somebody's, which stands among the methods by its name
    """

    vehicles: tuple[Vehicle, ...]
    processors: tuple[Processor, ...]
    methods: tuple[str, ...]
    scalars: tuple[Scalar, ...]
    limits: tuple[Where, ...] = ("fixed",)
    faults: Faults = "one"
    demands: tuple[str, ...]
    seed: int
    n: int
    theirs: foreign.Foreign | None = None

    @property
    def foreign_name(self) -> str:
        """Name of somebody's allocator; empty without one."""
        return self.theirs.name if self.theirs else ""


def emulate(plan: Plan) -> Iterator[Emulated]:
    """Yield each row as soon as it is counted; equal plans give equal rows.

    Raises UnknownName or DemandError at once, before anything is counted.
    """
    for method in plan.methods:
        if method not in (*BESIDE, plan.foreign_name):
            check(method)
    return _rows(plan, [(vehicle, _sets(vehicle, plan)) for vehicle in plan.vehicles])


def _rows(plan: Plan, asked: list[tuple[Vehicle, list[DemandSet]]]) -> Iterator[Emulated]:
    reasons = {processor: missing(processor) for processor in plan.processors}
    source = {"thrustbench": machine.commit()}  # rows in one record may come from different commits
    tools = {processor: versions(processor) | source for processor, reason in reasons.items() if not reason}
    combined = product(asked, plan.methods, plan.scalars, plan.limits, plan.processors)
    for (vehicle, sets), method, scalar, limits, processor in combined:
        row = Emulated(
            vehicle=vehicle.name,
            target=processor.name,
            method=method,
            scalar=scalar,
            limits=limits,
            faults=plan.faults,
            seed=plan.seed,
        )
        if processor not in tools:
            yield msgspec.structs.replace(row, status="missing", reason=reasons[processor])
            continue
        row = msgspec.structs.replace(row, tools=tools[processor])
        try:
            if method in BESIDE:
                beside = BESIDE[method]
                yield from beside.rows(
                    row, beside.kernel(vehicle, scalar, limits), vehicle, processor, plan.n
                )
                continue
            if plan.theirs and method == plan.foreign_name:
                made = foreign.kernel(plan.theirs, vehicle, limits)
            else:
                made = build_kernel(method, vehicle, scalar, limits, plan.faults)
            yield from _kernel_rows(row, made, processor, sets)
        except NotInstalled as lacking:
            yield msgspec.structs.replace(row, status="missing", reason=str(lacking))
        except NotApplicable as refusal:
            yield msgspec.structs.replace(row, status="refused", reason=str(refusal))
        except ToolError as failure:
            yield msgspec.structs.replace(row, status="failed", reason=str(failure))


def _kernel_rows(
    row: Emulated, kernel: Kernel, processor: Processor, sets: list[DemandSet]
) -> Iterator[Emulated]:
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(kernel, processor, Path(folder))
        row = msgspec.structs.replace(
            row, solver=kernel.solver, flash_bytes=image.flash_bytes, ram_static_bytes=image.ram_static_bytes
        )
        # Limits of each call mean nothing to a kernel that has the vehicle's in it.
        sets = [demands for demands in sets if kernel.limits == "call" or demands.f_min is None]
        for demands in sets:
            some = first(demands, RIVALS_SHARE) if kernel.solver else demands
            yield _counted(row, some, image, _answers(image, some))
        if not kernel.solver and sets:
            tried = _search(image, sets, row.seed)
            row = _counted(row, tried, image, _answers(image, tried))
            # Only the largest count is kept: the others depend on how the search went.
            row = msgspec.structs.replace(row, tried=len(tried.taus), instructions=row.instructions[-1:])
            yield _worst(row, image, sets[0].vehicle, tried.taus[: search.PARENTS])


def _worst(row: Emulated, image: Image, vehicle: Vehicle, costly: FloatArray) -> Emulated:
    """The row of a search with the most that is known of any call, and what none exceeds.

    ``costly`` are the demands (N, k) that it found to cost most.
    """
    kernel = image.kernel
    taus = extremes(vehicle, EXTREMES, float(np.finfo(SCALARS[kernel.scalar]).max))
    calls = kernel.calls(taus, vehicle.f_min, vehicle.f_max)
    counted = count(image, calls)
    known = max(row.instructions[-1][0], int(counted.instructions.max()))
    extreme = cycles(image, calls, counted)
    spans = {
        name: [max(ends) for ends in zip(span, extreme[name], strict=True)]
        for name, span in {image.processor.name: row.cycles, **row.boards}.items()
        if span and name in extreme
    }
    own = spans.pop(image.processor.name, [])
    at_most = None
    in_software = kernel.scalar == "double" and image.processor.scalars == ("float",)
    # Where an operation's length depends on the numbers, or loops on what was prepared, no bound is known.
    if not (in_software or kernel.prepared):
        with suppress(Unbounded):
            at_most = bound(image, vehicle.k, vehicle.n)
    known_off = None
    if row.faults != "none" and not kernel.prepared:
        known_off = search.worst_with_fault(kernel, image.processor, vehicle, costly)
    return msgspec.structs.replace(
        row, known=known, known_off=known_off, at_most=at_most, cycles=own, boards=spans
    )


def _answers(image: Image, demands: DemandSet) -> CallCounts:
    return count(image, image.kernel.calls(demands.taus, *demands.limits))


def _sets(vehicle: Vehicle, plan: Plan) -> list[DemandSet]:
    sets = []
    for name in plan.demands:
        try:
            sets.append(build_demands(name, vehicle, plan.seed, plan.n))
        except NotApplicable:  # no demand of this class exists for this vehicle
            continue
    return sets


def first(demands: DemandSet, share: float) -> DemandSet:
    """The first demands of a set, with the limits that they have."""
    few = slice(max(1, round(len(demands.taus) * share)))
    sides = () if demands.f_min is None else tuple(side[few].copy() for side in demands.limits)
    return labelled(demands.name, demands.vehicle, demands.taus[few].copy(), *sides, rate_hz=demands.rate_hz)


def _search(image: Image, sets: list[DemandSet], seed: int) -> DemandSet:
    vehicle = sets[0].vehicle

    def cost(taus: FloatArray) -> IndexArray:
        return count(image, image.kernel.calls(taus, vehicle.f_min, vehicle.f_max)).instructions

    start = np.concatenate([demands.taus[: search.SIZE // len(sets)] for demands in sets])
    taus, _ = search.climb(cost, start, vehicle.wrench_scale, np.random.default_rng(seed))
    return labelled(SEARCH, vehicle, taus)


def _counted(row: Emulated, demands: DemandSet, image: Image, counted: CallCounts) -> Emulated:
    is_foreign = image.kernel.library is not None
    agreed = (foreign.agreement if is_foreign else agreement)(image.kernel, demands, counted)
    known = cycles(image, image.kernel.calls(demands.taus, *demands.limits), counted)
    values, calls = np.unique(counted.instructions, return_counts=True)
    return msgspec.structs.replace(
        row,
        demands=demands.name,
        instructions=list(zip(values.tolist(), calls.tolist(), strict=True)),
        cycles=list(known.pop(image.processor.name, ())),
        boards={board: list(span) for board, span in known.items()},
        worst=demands.taus[int(counted.instructions.argmax())].tolist(),
        stack_bytes=int(counted.stack_bytes.max()),
        agrees=agreed.agrees,
        distance_rel_max=agreed.distance_rel_max,
        other_verdicts=agreed.other_verdicts,
        least=None if is_foreign else least_instructions(image.kernel, demands.vehicle),
        **_delivered(demands, counted),
    )


def _delivered(demands: DemandSet, counted: CallCounts) -> dict[str, float | None]:
    """Share of all demands delivered to 1 %; mean share along and largest angle of those answered."""
    answered = np.isin(counted.status, (Status.SOLVED, Status.PARTIAL))[:, None]
    asked = demands.vehicle, demands.taus, np.where(answered, counted.F, np.nan), demands.limits
    close = np.count_nonzero(relative_wrench_error(*asked) <= SERVED_WITHIN) / len(demands.taus)
    along, turned = share_along(*asked), direction_error_deg(*asked)
    return {
        "within_1pct_share": rounded(close),
        "along_mean": None if np.isnan(along).all() else rounded(np.nanmean(along)),
        "direction_error_max_deg": None if np.isnan(turned).all() else rounded(np.nanmax(turned)),
    }


def write(plan: Plan, directory: Path, *, add: bool) -> Iterator[Emulated]:
    """Count as planned and append each row to ``directory``'s record as it comes; raises RecordError.

    With ``add`` a record that is there is continued. A reader takes the later of two rows with the same
    names.
    """
    rows = emulate(plan)  # raises for a plan that is wrong, before a record is touched
    with Writer(directory) as writer:
        before = writer.resume() if add else None
        if before is None:
            writer.create(_header(plan))
        known = before.processors if before else []
        writer.extend(facts for processor in plan.processors if (facts := processor.facts) not in known)
        for row in rows:
            writer.append(row)
            yield row


def _header(plan: Plan) -> Header:
    settings = {
        "vehicles": [vehicle.name for vehicle in plan.vehicles],
        "targets": [processor.name for processor in plan.processors],
        "methods": list(plan.methods),
        "scalars": list(plan.scalars),
        "limits": list(plan.limits),
        "faults": plan.faults,
        "demands": list(plan.demands),
        "n_demands": plan.n,
    }
    return new_header(plan.seed, settings)
