"""Constrained allocation, eq. 4-5, by a live solver: set up once, only the demand changes."""

from alloc import solvers
from alloc.live.allocator import Live, live
from alloc.qp import pose_hard
from alloc.solvers import Level, Start
from alloc.vehicle import Vehicle

FORMULATION = "hard"
STARTS, LEVELS = solvers.starts, solvers.levels


def variants() -> dict[str, str]:
    """``qp/<solver>`` for every file in ``alloc/solvers``; what is missing, where something is."""
    return {f"qp/{name}": solvers.missing(name) for name in solvers.names()}


def SUMMARY(name: str) -> str:
    """One line for the catalogue."""
    return f"eq. 4-5 by {solvers.behind(name).ALGORITHM}"


def build(name: str, vehicle: Vehicle, start: Start | None = None, level: Level | None = None) -> Live:
    """Prepare ``qp/<solver>``; ``start`` is ``reused`` and ``level`` the most accurate unless given."""
    return live(name, FORMULATION, vehicle, pose_hard(vehicle), start, level)
