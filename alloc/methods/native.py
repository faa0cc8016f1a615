"""C99 generated for the vehicle, compiled here and called with nothing in between."""

from alloc.allocation import Allocator
from alloc.native import KERNELS, bound, missing
from alloc.vehicle import Vehicle

SUFFIX = "@native"
SUMMARIES = {
    "nullspace": "nullspace as C99 generated for the vehicle; exact optimum of eq. 4-5.",
    "pinv": "pinv as C99 generated for the vehicle, zero entries dropped.",
    "walsh": "walsh as C99 generated for the vehicle: a few multiplications, then butterflies.",
}


def variants() -> dict[str, str]:
    """Each kernel there is, with what is missing to compile it."""
    return {f"{kernel}{SUFFIX}": missing() for kernel in KERNELS}


def FORMULATION(name: str) -> str:
    """The same as the method in Python."""
    return "hard" if name.startswith("nullspace") else "unlimited"


def SUMMARY(name: str) -> str:
    """One line for the catalogue."""
    return SUMMARIES[name.removesuffix(SUFFIX)]


def build(name: str, vehicle: Vehicle) -> Allocator:
    """Generate, compile (or find in the cache) and bind; raises NotApplicable, NotInstalled."""
    return bound(name.removesuffix(SUFFIX), vehicle)
