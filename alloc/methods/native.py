"""C99 generated for the vehicle, compiled here and called with nothing in between."""

from alloc.allocation import Allocator
from alloc.c.bind import bound
from alloc.c.compiled import missing
from alloc.methods import Variant, recipe, recipes
from alloc.vehicle import Vehicle

FOREIGN = True


def variants() -> dict[str, Variant]:
    """``<method>@native`` for every method that has ``program``, with what is missing to compile it."""
    return {
        f"{each.name}@native": Variant(
            key=each.name,
            summary=f"{each.name} as C99 generated for the vehicle.",
            missing=missing(),
            twin=each.name,
            formulation=each.formulation,
            named_only=each.named_only,
            azimuths=each.azimuths,
        )
        for each in recipes().values()
    }


def build(name: str, vehicle: Vehicle) -> Allocator:
    """Generate, compile (or find in the cache) and bind; raises NotApplicable, NotInstalled."""
    return bound(recipe(name), vehicle)
