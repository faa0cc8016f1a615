"""Soft allocation, T f = tau + s with s penalised (Fossen 2021, eq. 11.38 without the load term).

Every demand has an answer, and also one that could be met is met only in part: the share of the
wrench that is left out is the price of never being infeasible.
"""

from alloc import solvers
from alloc.live.allocator import Live, live
from alloc.qp import pose_soft
from alloc.solvers import Level, Start
from alloc.vehicle import Vehicle

FORMULATION = "soft"
STARTS, LEVELS = solvers.starts, solvers.levels


def variants() -> dict[str, str]:
    """``qp-soft/<solver>`` for every file in ``alloc/solvers``; what is missing, where something is."""
    return {f"qp-soft/{name}": solvers.missing(name) for name in solvers.names()}


def SUMMARY(name: str) -> str:
    """One line for the catalogue."""
    return f"soft QP (Fossen 11.38) by {solvers.behind(name).ALGORITHM}"


def build(name: str, vehicle: Vehicle, start: Start | None = None, level: Level | None = None) -> Live:
    """Prepare ``qp-soft/<solver>``; ``start`` is ``reused`` and ``level`` the most accurate unless given."""
    return live(name, FORMULATION, vehicle, pose_soft(vehicle), start, level)
