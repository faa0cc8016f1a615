"""Constrained allocation, eq. 4-5, by a live solver: set up once, only the demand changes."""

from alloc import solvers
from alloc.live import Live
from alloc.qp import pose_hard
from alloc.solvers import Level, Start
from alloc.vehicle import Vehicle

FORMULATION = "hard"


def variants() -> dict[str, str]:
    """``qp/<solver>`` for every file in ``alloc/solvers``; what is missing, where something is."""
    return {f"qp/{name}": solvers.missing(name) for name in solvers.names()}


def STARTS(name: str) -> tuple[Start, ...]:
    """What the solver's binding can do."""
    return solvers.behind(name).STARTS


def LEVELS(name: str) -> tuple[Level, ...]:
    """The accuracy levels the solver has settings for."""
    return tuple(solvers.behind(name).SETTINGS)


def SUMMARY(name: str) -> str:
    """One line for the catalogue."""
    return f"eq. 4-5 by {solvers.behind(name).ALGORITHM}"


def build(name: str, vehicle: Vehicle, start: Start | None = None, level: Level | None = None) -> Live:
    """Prepare ``qp/<solver>``; ``start`` is ``reused`` and ``level`` the most accurate unless given."""
    solver = solvers.behind(name)
    posed = pose_hard(vehicle)
    level = level or solvers.default_level(solver)
    solve = solver.prepare(posed.qp, start or solvers.default_start(solver), level)
    return Live(FORMULATION, vehicle, posed, solve, solver.TOLERANCE[FORMULATION][level])
