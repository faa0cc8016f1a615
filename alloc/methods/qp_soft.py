"""Soft allocation, T f = tau + s with s penalised (Fossen 2021, eq. 11.38 without the load term).

Every demand has an answer, and even a demand that could be met is met only in part: the share of the
wrench that is left out is the price of never being infeasible.
"""

from alloc.formulations.soft import FORMULATION as SOFT
from alloc.live.allocator import Live, live
from alloc.methods import Variant, by_solver
from alloc.solvers import Level, Start
from alloc.vehicle import Vehicle

FORMULATION = SOFT.name
FOREIGN = True


def variants() -> dict[str, Variant]:
    """``qp-soft/<solver>`` for every file in ``alloc/solvers``, with how to install a missing binding."""
    return by_solver("qp-soft", "soft QP (Fossen 11.38)")


def build(solver: str, vehicle: Vehicle, start: Start | None = None, level: Level | None = None) -> Live:
    """Prepare ``qp-soft/<solver>``; ``start`` is ``reused`` and ``level`` the most accurate unless given."""
    return live(SOFT, solver, vehicle, start, level)
