"""libthrustbench: C that takes the matrix at run time, prepared for a vehicle, called as generated C is."""

from alloc import library
from alloc.allocation import Allocator
from alloc.c.compiled import missing
from alloc.library.bind import bound
from alloc.methods import Variant, recipe, recipes
from alloc.vehicle import Vehicle

FOREIGN = True


def variants() -> dict[str, Variant]:
    """``<method>@library`` for every method that the library's header declares."""
    known = recipes()
    return {
        f"{name}@library": Variant(
            key=name,
            summary=f"{name} by libthrustbench, C for any vehicle up to its sizes.",
            missing=missing(),
            formulation=known[name].formulation,
        )
        for name in library.calls()
        if name in known
    }


def build(name: str, vehicle: Vehicle) -> Allocator:
    """Compile (or find in the cache), prepare and bind; raises NotApplicable, NotInstalled."""
    return bound(recipe(name), vehicle)
