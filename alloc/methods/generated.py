"""Constrained allocation, eq. 4-5, by C that a solver's authors wrote, compiled for the vehicle."""

from alloc import rivals
from alloc.allocation import Allocator
from alloc.c.compiled import missing
from alloc.formulations import Family
from alloc.formulations.hard import FORMULATION as HARD
from alloc.methods import Variant
from alloc.rivals.wrapper import bound
from alloc.solvers import Level
from alloc.vehicle import Vehicle

FORMULATION = HARD.name
FAMILY = Family.GENERATED
FOREIGN = True


def variants() -> dict[str, Variant]:
    """``qp/<solver>@generated`` for every file in ``alloc/rivals/generators``, with what it lacks."""
    return {
        f"qp/{name}@generated": Variant(
            key=name,
            summary=f"eq. 4-5 in C for the vehicle, its answers checked, by {generator.ALGORITHM};"
            f" {max(generator.CAP.values()):,} iterations at most",
            levels=tuple(generator.TOLERANCE),
            missing=missing() or generator.missing(),
            solver=name,
        )
        for name, generator in ((name, rivals.load(name)) for name in rivals.names())
    }


def build(solver: str, vehicle: Vehicle, level: Level | None = None) -> Allocator:
    """Generate, compile (or find in the cache) and bind; raises NotApplicable, NotInstalled."""
    return bound(solver, vehicle, level)
