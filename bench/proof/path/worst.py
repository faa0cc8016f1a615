"""The most instructions of any call on a processor: a bound from the binary, and a call that attains it."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from alloc import FloatArray
from alloc.native.bounds import arguments
from bench.chips.count import count
from bench.chips.image import Image, link
from bench.chips.kernel import Kernel
from bench.chips.toolchain import Target, ToolError, versions
from bench.proof.path import lifted
from bench.proof.path.binary import Unbounded, disassembled, remaining
from bench.proof.path.operations import NotFollowed
from bench.proof.path.paths import PathsFound, ways
from bench.proof.proof import BinaryPath, WorstPath
from bench.proof.rounding.seen import attainable
from bench.proof.safety.harness import Subject

TARGETS = {"double": ("cortex-m7", "aarch64"), "float": ("cortex-m4f", "aarch64")}
"""Where each scalar is counted: on a Cortex-M4F double is software, whose length depends on the numbers."""
CALLS = 60
"""Demands of each fault that are run, beside those with NaN, infinity and the largest numbers."""


def worst_path(of: Subject, on: Target) -> WorstPath:
    """The costliest call for a target, and how much no call exceeds; with the ways through the binary.

    Of those ways the longest decides (``paths``), where the tools to follow them are there; else the longest
    way through the binary's graph is the bound.
    """
    calls = _calls(of)
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(_kernel(of), on, Path(folder))
        reason, at_most, followed = "", None, PathsFound([], 0, False)
        try:
            lengths = remaining(disassembled(image), image.entry, _rounds(of))
            at_most = lengths[image.entry]
            followed = _followed(of, image, lengths)
            at_most = followed.at_most
        except (Unbounded, NotFollowed) as unknown:
            reason = str(unknown)
        taken = [
            [*way.call[: of.vehicle.k], way.fault, *way.call[of.vehicle.k :]]
            for way in followed.found
            if way.call.size
        ]
        calls = np.vstack([calls, *taken])
        counted = count(image, calls)
    expected = [way.instructions for way in followed.found if way.call.size]
    if expected != counted.instructions[len(calls) - len(taken) :].tolist():
        raise ToolError(f"{on.name}: a path has another length than the emulator counts")
    worst = int(counted.instructions.argmax())
    if at_most is not None and counted.instructions[worst] > at_most:
        raise ToolError(f"{on.name}: a call takes more instructions than the longest path has")
    k = of.vehicle.k
    return WorstPath(
        target=on.name,
        compiler=versions(on)[f"{on.tools}gcc"],
        at_most=at_most,
        attained=int(counted.instructions[worst]),
        calls=len(calls),
        by_status={
            str(status): int(counted.instructions[counted.status == status].max())
            for status in sorted(set(counted.status.tolist()))
        },
        tau=_named(calls[worst, :k]),
        fault=int(calls[worst, k]),
        reason=reason,
        paths=[
            BinaryPath(
                fault=way.fault,
                instructions=way.instructions,
                verdict="infeasible" if way.infeasible else "taken" if way.call.size else "neither",
                call=_named(way.call),
            )
            for way in sorted(followed.found, key=lambda way: -way.instructions)
        ],
        all_paths=followed.complete,
    )


def _named(call: FloatArray) -> list[float | str]:
    return [float(each) if np.isfinite(each) else str(each) for each in call]


def _followed(of: Subject, image: Image, lengths: dict[int, int]) -> PathsFound:
    if words := lifted.missing():
        raise NotFollowed(words)
    if "cascade(" in of.source:
        raise NotFollowed("loops that data end: the bound takes each loop's most rounds")
    scalar = np.float32 if of.scalar == "float" else np.float64
    calls = {fault: sampled(of, fault, scalar) for fault in range(-1, of.vehicle.n)}
    names = arguments(of.limits, of.levels, "fault").split(", ")
    # With three dimensions there are more ways than can be looked at, so one of them decides nothing.
    closely = len(of.vehicle.working) - of.vehicle.rank < 3
    return ways(lifted.Lifted(image), image.entry, lengths, calls, scalar, names, closely)


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


def _calls(of: Subject) -> FloatArray:
    """(N, width) calls of every fault: demands inside and far outside, and such as are no numbers."""
    vehicle = of.vehicle
    rng = np.random.default_rng(2004)
    reach = rng.choice([0.3, 1.0, 1.5, 10.0], (CALLS, 1))
    taus = [reach * rng.uniform(vehicle.f_min, vehicle.f_max, (CALLS, vehicle.n)) @ vehicle.TP.T]
    taus.append(np.zeros((1, vehicle.k)))
    largest = float(np.finfo(np.float32 if of.scalar == "float" else np.float64).max)
    for odd in (np.nan, np.inf, largest, -largest):
        taus += [np.full((1, vehicle.k), odd), np.where(np.eye(vehicle.k) == 1, odd, 0.0)]
    asked = np.vstack(taus)
    faults = np.arange(-1, vehicle.n)
    calls = np.hstack([np.tile(asked, (len(faults), 1)), np.repeat(faults, len(asked))[:, None]])
    if of.limits == "fixed":
        return calls
    return np.hstack([calls, np.tile(np.concatenate([vehicle.f_min, vehicle.f_max]), (len(calls), 1))])


SAMPLES = 1000
"""Calls of each fault that are followed at once, of each kind."""


def sampled(of: Subject, fault: int, scalar: Any) -> dict[str, FloatArray]:
    """Inputs (size, N) by name: demands about the edge of what can be made, and such as overflow."""
    vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
    rng = np.random.default_rng(2004)
    beyond = rng.choice([1.0, 1.0, 1.0 + 1e-6, 1.0 + 1e-5, 1.001, 1.1, 1.5, 3.0, 10.0, 1e3], SAMPLES)
    usual = beyond * attainable(vehicle, rng, SAMPLES)
    usual[rng.random(usual.shape) < 0.1] = 0.0
    largest = float(np.finfo(scalar).max)
    odd = np.array([0.0, np.nan, np.inf, -np.inf, largest, -largest, largest / 2, -largest / 2])
    drawn = odd[rng.integers(0, len(odd), usual.shape)]
    kind = rng.random(usual.shape)
    mixed = np.where(
        kind < 0.5, drawn, np.where(kind < 0.8, largest * rng.uniform(-1, 1, usual.shape), usual)
    )
    inputs = {"tau": np.hstack([usual, mixed])}
    if of.limits == "call":
        ends = {"f_min": vehicle.f_min, "f_max": vehicle.f_max}
        inputs |= {name: np.repeat(each[:, None], 2 * SAMPLES, axis=1) for name, each in ends.items()}
    return inputs
