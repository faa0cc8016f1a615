"""C99 generated for the vehicle, compiled here and called with nothing in between."""

from alloc.allocation import Allocator
from alloc.native import RECIPES, bound, missing
from alloc.vehicle import Vehicle

KERNELS = {f"{kernel}@native": kernel for kernel in RECIPES}


def variants() -> dict[str, str]:
    """Each kernel there is, with what is missing to compile it."""
    return dict.fromkeys(KERNELS, missing())


def FORMULATION(name: str) -> str:
    """The same as the method in Python."""
    return RECIPES[KERNELS[name]].formulation


def SUMMARY(name: str) -> str:
    """One line for the catalogue."""
    return RECIPES[KERNELS[name]].summary


def build(name: str, vehicle: Vehicle) -> Allocator:
    """Generate, compile (or find in the cache) and bind; raises NotApplicable, NotInstalled."""
    return bound(KERNELS[name], vehicle)
