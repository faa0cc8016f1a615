"""Counts the C from thrusts to the commands of ESCs, on processors that are emulated."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np

from alloc import NotApplicable, Vehicle
from alloc.allocation import FloatArray
from alloc.c import last_metre, sources, to_escs
from alloc.methods import recipe
from alloc.program import Scalar, Where
from bench.chips.count import CallCounts, count
from bench.chips.image import link
from bench.chips.kernel import Kernel
from bench.chips.target import Target
from bench.record import Emulated

METHOD = "esc"
"""What a table calls it, and ``thrustbench emulate --method``."""
BEHIND = "pinv"
"""The method behind whose C it stands; its instructions are not counted."""
SIZES = {"thrusts": 1.0, "small thrusts": 0.05}
"""Largest thrusts of each set, relative to the vehicle's largest limit [-]."""
MADE = 1e-5
"""What rounding to float moves a thrust by, relative to the largest [-]; where that changes a command by a
step, the other one is right too."""
TURNED = 0.02
"""Share of thrusts that may be a step away for that."""


def kernel(vehicle: Vehicle, scalar: Scalar, limits: Where) -> Kernel:
    """NAME_esc as a kernel whose demand is f, limits where they are arguments, and the voltage."""
    if not vehicle.esc:
        raise NotApplicable(f"{vehicle.name}: has no ESCs; add 'esc' to its file")
    made = recipe(BEHIND)
    last = last_metre(vehicle, made, scalar, limits)
    n, call = vehicle.n, limits == "call"
    ends = f"tau + {n}, tau + {2 * n}, " * call
    width = n + 2 * n * call + 1
    return Kernel(
        method=METHOD,
        twin="",
        scalar=scalar,
        k=width,
        n=n,
        entry=f"{last.name}_esc",
        declaration=f'#include "{last.name}_esc.h"\nstatic {last.command} command[{n}];',
        arguments=f"tau, {ends}tau[{width - 1}], command, f",
        sources=sources(vehicle, made, scalar, limits=limits) | to_escs(last),
    )


def rows(row: Emulated, made: Kernel, vehicle: Vehicle, target: Target, n: int) -> Iterator[Emulated]:
    """A row for each set of n thrusts, at voltages all over the curve; raises as ``link`` of an image."""
    rng = np.random.default_rng(row.seed)
    known = [float(v) for esc in vehicle.esc for v in esc.volts if np.isfinite(v)] or [1.0]
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(made, target, Path(folder))
        for name, size in SIZES.items():
            f = rng.uniform(-1.0, 1.0, (n, vehicle.n)) * size * vehicle.f_scale
            volts = rng.uniform(min(known), max(known), n)
            ends = [np.tile(side, (n, 1)) for side in (vehicle.f_min, vehicle.f_max)] * (row.limits == "call")
            counted = count(image, np.hstack([f, *ends, volts[:, None]]))
            values, calls = np.unique(counted.instructions, return_counts=True)
            agrees, apart = _agrees(vehicle, f, volts, counted)
            yield msgspec.structs.replace(
                row,
                demands=name,
                flash_bytes=image.flash_bytes,
                ram_static_bytes=image.ram_static_bytes,
                instructions=list(zip(values.tolist(), calls.tolist(), strict=True)),
                worst=[*f[int(counted.instructions.argmax())].tolist()],
                stack_bytes=int(counted.stack_bytes.max()),
                agrees=agrees,
                distance_rel_max=apart,
                other_verdicts=0,
            )


def _agrees(vehicle: Vehicle, f: FloatArray, volts: FloatArray, counted: CallCounts) -> tuple[bool, float]:
    """Whether what is made is Python's, but for some a step away; and the largest difference else."""
    sent = vehicle.commands(f, volts)
    apart = np.abs(counted.F - sent.f) / vehicle.f_scale
    other = apart > MADE
    step = np.array([esc.step for esc in vehicle.esc])
    beside = np.abs(vehicle.thrusts(sent.u + step, volts) - vehicle.thrusts(sent.u - step, volts))
    near = apart * vehicle.f_scale <= beside + MADE * vehicle.f_scale
    return bool(near.all() and other.mean() <= TURNED), float(np.where(other, 0.0, apart).max())
