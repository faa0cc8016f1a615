"""Calls with a thruster off: the kernel with the fault as an argument, and what its costliest call takes."""

import tempfile
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from bench.chips.count import count
from bench.chips.image import link
from bench.chips.kernel import SCALARS, Kernel
from bench.chips.target import Target
from bench.demands.corners import extremes

CALLS = 50
"""Demands of each kind for each fault: about the edge of what is left, far outside, and such as overflow."""


def with_fault_asked(kernel: Kernel) -> Kernel:
    """The same kernel, called with the fault as one number more behind tau."""
    return replace(kernel, k=kernel.k + 1, arguments=kernel.arguments.replace("-1", f"(int)tau[{kernel.k}]"))


def most_with_one_off(kernel: Kernel, target: Target, vehicle: Vehicle, taus: FloatArray) -> int | None:
    """Most instructions of a call with any one thruster off; None where none can be.

    Asked are demands at the limits of what is left, and those (N, k) that cost the whole vehicle most.
    """
    asked = []
    largest = float(np.finfo(SCALARS[kernel.scalar]).max)
    for fault in range(vehicle.n):
        with suppress(VehicleError):  # the last thruster that pushes can't be taken off
            some = np.vstack([extremes(vehicle.with_fault(fault), CALLS, largest), taus])
            asked.append(np.column_stack([some, np.full(len(some), float(fault))]))
    if not asked:
        return None
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        other = with_fault_asked(kernel)
        calls = other.calls(np.vstack(asked), vehicle.f_min, vehicle.f_max)
        return int(count(link(other, target, Path(folder)), calls).instructions.max())
