"""The most instructions of any call on a processor: a bound from the binary, and a call that attains it."""

import tempfile
from pathlib import Path

import numpy as np

from alloc import FloatArray
from alloc.native.bounds import arguments
from bench.emulation.count import count
from bench.emulation.image import link
from bench.emulation.kernel import Kernel
from bench.emulation.toolchain import Target, versions
from bench.prove.binary import Unbounded, disassembled, longest
from bench.prove.harness import Subject
from bench.prove.proof import WorstPath

TARGETS = {"double": ("cortex-m7", "aarch64"), "float": ("cortex-m4f", "aarch64")}
"""Where each scalar is counted: on a Cortex-M4F double is software, whose length depends on the numbers."""
CALLS = 60
"""Demands of each fault that are run, beside those with NaN, infinity and the largest numbers."""


def worst_path(of: Subject, on: Target) -> WorstPath:
    """The longest way through the kernel for a target, and the costliest call of all that were run."""
    calls = _calls(of)
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(_kernel(of), on, Path(folder))
        reason = ""
        try:
            at_most = longest(disassembled(image), image.entry, _rounds(of))
        except Unbounded as unbounded:
            at_most, reason = None, str(unbounded)
        counted = count(image, calls)
    worst = int(counted.instructions.argmax())
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
        tau=[each if np.isfinite(each) else str(each) for each in calls[worst, :k].tolist()],
        fault=int(calls[worst, k]),
        reason=reason,
    )


def _kernel(of: Subject) -> Kernel:
    """The kernel as the emulator's driver calls it, with the fault as one number more behind tau."""
    k, shares = of.vehicle.k, f"\nstatic {of.scalar} share[{of.levels}];" if of.levels else ""
    return Kernel(
        method=f"{of.kernel}@native",
        twin=of.kernel,
        scalar=of.scalar,
        k=k + 1,
        n=of.vehicle.n,
        entry=of.name,
        declaration=f'#include "{of.name}.h"{shares}',
        arguments=arguments(of.limits, of.levels, f"(int)tau[{k}]"),
        sources=of.files,
        limits=of.limits,
    )


def _rounds(of: Subject) -> int:
    """How often a loop may go round: the only ones, but in a cascade, look at tau or at limits."""
    if "cascade(" in of.source:
        raise Unbounded("a cascade")
    return of.vehicle.k if of.limits == "fixed" else max(of.vehicle.k, of.vehicle.n)


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
