"""Soft allocation, T f = tau + s with s penalised (Fossen 2021, eq. 11.38 without the load term).

Every demand has an answer, and also one that could be met is met only in part: the share of the
wrench that is left out is the price of never being infeasible.
"""

from alloc import solvers
from alloc.formulations.soft import FORMULATION as SOFT
from alloc.live.allocator import Live, live
from alloc.methods import Variant
from alloc.solvers import Level, Start
from alloc.vehicle import Vehicle

FORMULATION = SOFT.name
FOREIGN = True


def variants() -> dict[str, Variant]:
    """``qp-soft/<solver>`` for every file in ``alloc/solvers``; what is missing, where something is."""
    return {
        f"qp-soft/{name}": Variant(
            key=name,
            summary=f"soft QP (Fossen 11.38) by {solver.ALGORITHM}",
            missing=solvers.missing(name),
            solver=name,
            starts=solver.STARTS,
            levels=tuple(solver.SETTINGS),
        )
        for name, solver in solvers.all_solvers().items()
    }


def build(solver: str, vehicle: Vehicle, start: Start | None = None, level: Level | None = None) -> Live:
    """Prepare ``qp-soft/<solver>``; ``start`` is ``reused`` and ``level`` the most accurate unless given."""
    return live(SOFT, solver, vehicle, start, level)
