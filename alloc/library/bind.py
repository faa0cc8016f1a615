"""The library as an allocator in Python: compiled, prepared for a vehicle, and called as generated C is."""

import ctypes
from functools import cache
from pathlib import Path

from alloc.allocation import Allocator
from alloc.c.bind import native
from alloc.c.compiled import shared_library
from alloc.c.target import Recipe
from alloc.errors import NotApplicable
from alloc.library import NAME
from alloc.library.adapter import adapter, levels, name, sized
from alloc.vehicle import Vehicle

REFUSED = {-3: "its numbers are none that the library takes", -4: "T nearly loses rank"}


def bound(kernel: Recipe, vehicle: Vehicle) -> Allocator:
    """The library's answer to a method for this vehicle; raises NotApplicable or NotInstalled."""
    twin = kernel.build(vehicle)  # states the promises, and refuses what the C would not cover
    own = name(vehicle, kernel.name)
    path = shared_library(own, adapter(vehicle, kernel.name), shared=sized(vehicle))
    if status := _prepared(path, own):
        raise NotApplicable(f"{vehicle.name}: {NAME} does not prepare it: {REFUSED[status]}")
    return native(
        path,
        (f"{own}_fixed", f"{own}_call"),
        vehicle,
        formulation=twin.formulation,
        limited=twin.limited,
        tolerance=twin.tolerance,
        levels=levels(kernel.name, vehicle),
    )


@cache
def _prepared(path: Path, own: str) -> int:
    """Result of preparing the library; made once, since the allocator may be in use later on."""
    return int(ctypes.CDLL(str(path))[f"{own}_prepare"]())
