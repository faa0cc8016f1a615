"""Counts the C from thrusts to the commands of ESCs, on processors that are emulated."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np

from alloc import NotApplicable, Vehicle
from alloc.allocation import FloatArray, IndexArray
from alloc.c import Target, command_type, sources, to_escs
from alloc.c.esc_selftest import esc_status
from alloc.methods import recipe
from alloc.program import Faults, Scalar, Where
from alloc.vehicle.esc import Sent
from bench.chips.count import CallCounts, count
from bench.chips.image import link
from bench.chips.kernels import Kernel
from bench.chips.processors import Processor
from bench.record import Emulated

METHOD = "esc"
"""Name in tables, and for ``thrustbench emulate --method``."""
BEHIND = "pinv"
"""The method behind whose C it stands; its instructions are not counted."""
SIZES = {"thrusts": 1.0, "small-thrusts": 0.05}
"""Largest thrusts of each set, relative to the vehicle's largest limit [-]."""
MADE = 1e-5
"""Move of a thrust by rounding to float, relative to the largest [-]; where it changes a command by a
step, the other one is right too."""
TURNED = 0.02
"""Share of thrusts that may be a step away for that."""


def kernel(vehicle: Vehicle, scalar: Scalar, limits: Where, faults: Faults = "one") -> Kernel:
    """NAME_esc as a kernel whose demand is f, limits where they are arguments, and the voltage."""
    if not vehicle.esc:
        raise NotApplicable(f"{vehicle.name}: has no ESCs; add 'esc' to its file")
    target = Target(vehicle=vehicle, method=recipe(BEHIND), scalar=scalar, limits=limits, faults=faults)
    n, given = vehicle.n, width(vehicle.n, limits)
    ends = f"tau + {n}, tau + {2 * n}, " * (limits == "call")
    return Kernel(
        method=METHOD,
        twin="",
        scalar=scalar,
        k=given,
        n=n,
        entry=f"{target.name}_esc",
        declaration=f'#include "{target.name}_esc.h"\nstatic {command_type(target)} command[{n}];',
        arguments=f"tau, {ends}tau[{given - 1}], command, f",
        sources=sources(target) | to_escs(target),
    )


def width(n: int, limits: Where) -> int:
    """Number of a call's arguments: thrusts, both limits where they are arguments, and the voltage."""
    return (3 * n if limits == "call" else n) + 1


def calls(vehicle: Vehicle, limits: Where, n: int, seed: int) -> dict[str, FloatArray]:
    """Calls (n, width) of each set: thrusts, limits where they are arguments, any voltage of the curve."""
    rng = np.random.default_rng(seed)
    known = [float(v) for esc in vehicle.esc for v in esc.volts if np.isfinite(v)] or [1.0]
    made = {}
    for name, size in SIZES.items():
        f = rng.uniform(-1.0, 1.0, (n, vehicle.n)) * size * vehicle.f_scale
        volts = rng.uniform(min(known), max(known), n)
        ends = [np.tile(side, (n, 1)) for side in (vehicle.f_min, vehicle.f_max)] * (limits == "call")
        made[name] = np.hstack([f, *ends, volts[:, None]])
    return made


def rows(row: Emulated, made: Kernel, vehicle: Vehicle, processor: Processor, n: int) -> Iterator[Emulated]:
    """A row for each set of n thrusts; raises as ``link`` of an image."""
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        image = link(made, processor, Path(folder))
        sized = msgspec.structs.replace(
            row, flash_bytes=image.flash_bytes, ram_static_bytes=image.ram_static_bytes
        )
        for name, asked in calls(vehicle, "call" if row.limits == "call" else "fixed", n, row.seed).items():
            yield counted_row(sized, name, vehicle, asked, count(image, asked))


def counted_row(
    row: Emulated, name: str, vehicle: Vehicle, asked: FloatArray, counted: CallCounts
) -> Emulated:
    """The row with what calls (N, width) of a set took, and whether Python makes the same thrusts."""
    values, often = np.unique(counted.instructions, return_counts=True)
    agrees, apart = agreement(vehicle, asked, counted.F, counted.status)
    return msgspec.structs.replace(
        row,
        demands=name,
        instructions=list(zip(values.tolist(), often.tolist(), strict=True)),
        worst=asked[int(counted.instructions.argmax()), : vehicle.n].tolist(),
        stack_bytes=int(counted.stack_bytes.max()),
        agrees=agrees,
        distance_rel_max=apart,
    )


def agreement(
    vehicle: Vehicle, asked: FloatArray, made: FloatArray, status: IndexArray
) -> tuple[bool, float]:
    """True if thrusts (N, n) of calls (N, width) are Python's, some a step away, and status (N,) too.

    The second number is the largest difference of the others, relative to the largest limit.
    """
    f, *ends = np.split(asked[:, :-1], asked.shape[1] // vehicle.n, axis=1)
    volts = asked[:, -1]
    f_min, f_max = ends or (None, None)
    sent = vehicle.commands(f, volts, f_min=f_min, f_max=f_max)
    apart = np.abs(made - sent.f) / vehicle.f_scale
    other = ~(apart <= MADE)
    step = np.array([esc.step for esc in vehicle.esc])
    beside = np.abs(vehicle.thrusts(sent.u + step, volts) - vehicle.thrusts(sent.u - step, volts))
    near = apart * vehicle.f_scale <= beside + MADE * vehicle.f_scale
    expected = np.array([esc_status(Sent(*each)) for each in zip(*sent, strict=True)])
    agrees = bool((status == expected).all() and near.all() and other.mean() <= TURNED)
    return agrees, float(np.where(other, 0.0, apart).max(initial=0.0))
