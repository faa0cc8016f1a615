"""C99 generated for the vehicle, compiled here and called with nothing in between."""

from alloc.allocation import Allocator
from alloc.methods import Variant
from alloc.native import RECIPES, bound, missing
from alloc.vehicle import Vehicle

FOREIGN = True


def variants() -> dict[str, Variant]:
    """``<kernel>@native`` for every recipe, with what is missing to compile it."""
    return {
        f"{kernel}@native": Variant(
            key=kernel,
            summary=recipe.summary,
            missing=missing(),
            twin=kernel,
            formulation=recipe.formulation,
        )
        for kernel, recipe in RECIPES.items()
    }


def build(kernel: str, vehicle: Vehicle) -> Allocator:
    """Generate, compile (or find in the cache) and bind; raises NotApplicable, NotInstalled."""
    return bound(kernel, vehicle)
