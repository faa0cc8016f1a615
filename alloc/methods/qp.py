"""Constrained allocation, eq. 4-5, by a live solver: set up once, only the demand changes."""

from alloc.formulations import Family
from alloc.formulations.hard import FORMULATION as HARD
from alloc.live.allocator import Live, live
from alloc.methods import Variant, by_solver
from alloc.solvers import Level, Start
from alloc.vehicle import Vehicle

FORMULATION = HARD.name
AZIMUTHS = True
FAMILY = Family.LIVE
FOREIGN = True


def variants() -> dict[str, Variant]:
    """``qp/<solver>`` for every file in ``alloc/solvers``, with how to install a missing binding."""
    return by_solver("qp", "eq. 4-5")


def build(solver: str, vehicle: Vehicle, start: Start | None = None, level: Level | None = None) -> Live:
    """Prepare ``qp/<solver>``; ``start`` is ``reused`` and ``level`` the most accurate unless given."""
    return live(HARD, solver, vehicle, start, level)
