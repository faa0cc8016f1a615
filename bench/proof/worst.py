"""The most instructions of any call: at least what one was seen to take, at most what the binary allows."""

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from bench.chips.bounds import Unbounded, bound
from bench.chips.count import count
from bench.chips.image import Image, link
from bench.chips.kernels import Kernel, native_kernel
from bench.chips.processors import Processor, processors
from bench.chips.search import PARENTS, climb, with_fault_argument
from bench.chips.toolchain import ToolError, missing, versions
from bench.demands.corners import extremes
from bench.proof.proof import Claim, WorstPath, unproved
from bench.proof.source import Subject
from bench.record import Emulated

CALLS = 200
"""Demands that are run for each fault: so many about the edge of the attainable set, as many that
overflow."""
FAR = 10.0
"""Times the size of a wrench, beyond which a search does not begin."""
WORST = "No call takes more instructions than the bound."


class Contradicted(Exception):
    """A call takes more than the bound, so the bound is none; the message names the call."""


Counted = Mapping[str, Sequence[Sequence[float]]]
"""By target, demands (k,) that were counted before, each the costliest of its set [N, N m]."""


def counted_before(rows: Iterable[Emulated], of: Subject) -> Counted:
    """Costliest call that ``thrustbench emulate`` found for a kernel, the same or an older one."""
    found: dict[str, list[list[float]]] = {}
    for row in rows:
        names = row.vehicle, row.method, row.scalar, row.limits
        mine = names == (of.vehicle.name, f"{of.kernel}@native", of.scalar, of.limits)
        if mine and len(row.worst) == of.vehicle.k:
            found.setdefault(row.target, []).append(row.worst)
    return found


def worst_path(of: Subject, on: Processor, before: Counted = MappingProxyType({})) -> WorstPath:
    """The interval of the worst path for a target, with the costliest call that was seen.

    ``attained`` is the most that any call took: demands of all kinds with every thruster off, those that were
    counted ``before``, and what a search makes of them. ``at_most`` is the longest way through the binary's
    graph. Raises Contradicted where a call takes more than that.
    """
    scalar = np.float32 if of.scalar == "float" else np.float64
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(_kernel(of), on, Path(folder))
        reason, at_most = "", None
        try:
            at_most = bound(image, of.vehicle.k, of.vehicle.n)
        except Unbounded as unknown:
            reason = str(unknown)
        calls, counted, status = _searched(of, image, scalar, before.get(on.name, ()))
    worst, k = int(counted.argmax()), of.vehicle.k
    if at_most is not None and counted[worst] > at_most:
        call = f"τ = {_named(calls[worst, :k])} with thruster {int(calls[worst, k])} off"
        raise Contradicted(
            f"{on.name}: {call} takes {counted[worst]} instructions, the longest path {at_most}"
        )
    return WorstPath(
        target=on.name,
        compiler=versions(on)[f"{on.tools}gcc"],
        at_most=at_most,
        attained=int(counted[worst]),
        calls=len(calls),
        by_status={str(each): int(counted[status == each].max()) for each in sorted(set(status.tolist()))},
        tau=_named(calls[worst, :k]),
        fault=int(calls[worst, k]),
        reason=reason,
    )


def worst_paths(
    of: Subject, before: Counted = MappingProxyType({})
) -> tuple[list[WorstPath], list[Claim], list[Claim]]:
    """The worst paths, bounds that a call disproves, and targets that lack a tool."""
    paths, refuted, lacking = list[WorstPath](), list[Claim](), list[Claim]()
    for processor in processors():
        if of.scalar not in processor.scalars:  # in software its length depends on the numbers
            continue
        words = missing(processor)
        try:
            if not words:
                paths.append(worst_path(of, processor, before))
        except Contradicted as error:
            refuted.append(unproved(WORST, [str(error)]))
        except ToolError as error:
            words = str(error)
        if words:
            lacking.append(unproved(f"The worst path on {processor.name}.", [words]))
    return paths, refuted, lacking


def _named(call: FloatArray) -> list[float | str]:
    return [float(each) if np.isfinite(each) else str(each) for each in call]


def _searched(
    of: Subject, image: Image, scalar: type[np.floating], before: Sequence[Sequence[float]]
) -> tuple[FloatArray, IndexArray, IndexArray]:
    """(N, width) calls, and of each its instructions and status; the search begins at the costliest."""
    vehicle, k = of.vehicle, of.vehicle.k
    asked = [_calls(of, _extremes(of, fault, scalar), fault) for fault in range(-1, vehicle.n)]
    given = np.vstack([*asked, _calls(of, np.reshape(before, (-1, k)), -1)])
    first = count(image, given)
    tried, counts, statuses = [given], [first.instructions], [first.status]
    worst = given[int(first.instructions.argmax())]

    def cost(taus: FloatArray) -> IndexArray:
        asked = np.hstack([taus, np.tile(worst[k:], (len(taus), 1))])
        counted = count(image, asked)
        tried.append(asked)
        counts.append(counted.instructions)
        statuses.append(counted.status)
        return counted.instructions

    usual = (given[:, k] == worst[k]) & (np.abs(given[:, :k]) <= FAR * vehicle.wrench_scale).all(axis=1)
    order = np.argsort(-first.instructions[usual], kind="stable")
    start = given[usual][order][:PARENTS, :k]
    climb(cost, start, vehicle.wrench_scale, np.random.default_rng(2004))
    return np.vstack(tried), np.concatenate(counts), np.concatenate(statuses)


def _kernel(of: Subject) -> Kernel:
    """The kernel as the emulator's driver calls it, with the fault as one number more behind tau."""
    return with_fault_argument(native_kernel(of.target, of.files))


def _extremes(of: Subject, fault: int, scalar: type[np.floating]) -> FloatArray:
    vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
    return extremes(vehicle, CALLS, float(np.finfo(scalar).max))


def _calls(of: Subject, taus: FloatArray, fault: int) -> FloatArray:
    """(N, width) calls with these demands (N, k) and a fault."""
    calls = np.hstack([taus, np.full((len(taus), 1), float(fault))])
    if of.limits == "fixed":
        return calls
    return np.hstack([calls, np.tile(np.concatenate([of.vehicle.f_min, of.vehicle.f_max]), (len(calls), 1))])
