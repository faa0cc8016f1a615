"""The most instructions of any call: at least what one was seen to take, at most what the binary allows."""

import tempfile
from pathlib import Path

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.c import arguments
from bench.chips.count import count
from bench.chips.image import Image, link
from bench.chips.kernel import Kernel
from bench.chips.longest import Unbounded, disassembled, longest
from bench.chips.search import PARENTS, climb
from bench.chips.target import Target
from bench.chips.toolchain import versions
from bench.proof.proof import WorstPath
from bench.proof.rounding.seen import attainable
from bench.proof.safety.harness import Subject

CALLS = 200
"""Demands of each fault that are run of each kind: about the edge of what the vehicle can do, and such as
overflow."""
FAR = 10.0
"""Times the size of a wrench, beyond which a search does not begin."""


class Contradicted(Exception):
    """A call takes more than the bound, so the bound is none; the message names the call."""


def worst_path(of: Subject, on: Target) -> WorstPath:
    """The interval of the worst path for a target, with the costliest call that was seen.

    ``attained`` is the most that any call took: demands of all kinds with every thruster off, and what a
    search makes of them. ``at_most`` is the longest way through the binary's graph. Raises Contradicted where
    a call takes more than that.
    """
    scalar = np.float32 if of.scalar == "float" else np.float64
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(_kernel(of), on, Path(folder))
        reason, at_most = "", None
        try:
            at_most = longest(disassembled(image), image.entry, _rounds(of))
        except Unbounded as unknown:
            reason = str(unknown)
        calls, counted, status = _searched(of, image, scalar)
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


def _named(call: FloatArray) -> list[float | str]:
    return [float(each) if np.isfinite(each) else str(each) for each in call]


def _searched(
    of: Subject, image: Image, scalar: type[np.floating]
) -> tuple[FloatArray, IndexArray, IndexArray]:
    """(N, width) calls, and of each its instructions and status; the search begins at the costliest."""
    vehicle, k = of.vehicle, of.vehicle.k
    given = np.vstack([_calls(of, fault, scalar) for fault in range(-1, vehicle.n)])
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
    k = of.vehicle.k
    return Kernel(
        method=f"{of.kernel}@native",
        twin=of.kernel,
        scalar=of.scalar,
        k=k + 1,
        n=of.vehicle.n,
        entry=of.name,
        declaration=f'#include "{of.name}.h"',
        arguments=arguments(of.limits, of.levels, f"(int)tau[{k}]"),
        sources=of.files,
        limits=of.limits,
        levels=of.levels,
    )


def _rounds(of: Subject) -> int:
    """How often a loop's head may be reached: all go over axes or thrusters, and look once more to end."""
    return max(of.vehicle.k, of.vehicle.n) + 1


def _calls(of: Subject, fault: int, scalar: type[np.floating]) -> FloatArray:
    """(N, width) calls of one fault: demands about the edge, far outside, and such as are no numbers."""
    vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
    rng = np.random.default_rng(2004)
    beyond = rng.choice([0.3, 1.0, 1.0, 1.0 + 1e-6, 1.0 + 1e-5, 1.001, 1.1, 1.5, 10.0, 1e3], CALLS)
    usual = (beyond * attainable(vehicle, rng, CALLS)).T
    usual[rng.random(usual.shape) < 0.1] = 0.0
    largest = float(np.finfo(scalar).max)
    odd = np.array([np.nan, np.inf, -np.inf, largest, -largest, largest / 2, -largest / 2])
    mixed = np.where(rng.random(usual.shape) < 0.5, rng.choice([0.0, *odd], usual.shape), usual)
    alone = [np.where(np.eye(vehicle.k) == 1, each, 0.0) for each in odd]
    taus = np.vstack([usual, mixed, largest * rng.uniform(-1.0, 1.0, usual.shape), *alone])
    taus = np.vstack([taus, np.zeros((1, vehicle.k)), np.repeat(odd[:, None], vehicle.k, axis=1)])
    calls = np.hstack([taus, np.full((len(taus), 1), float(fault))])
    if of.limits == "fixed":
        return calls
    return np.hstack([calls, np.tile(np.concatenate([of.vehicle.f_min, of.vehicle.f_max]), (len(calls), 1))])
