"""Soft allocation, T f = tau + s with s penalised (Fossen 2021, eq. 11.38 without the load term).

Every demand has an answer, and also one that could be met is met only in part: the share of the
wrench that is left out is the price of never being infeasible.
"""

from alloc import solvers
from alloc.live import Live
from alloc.qp import pose_soft
from alloc.solvers import Level, Start
from alloc.vehicle import Vehicle

FORMULATION = "soft"


def variants() -> dict[str, str]:
    """``qp-soft/<solver>`` for every file in ``alloc/solvers``; what is missing, where something is."""
    return {f"qp-soft/{name}": solvers.missing(name) for name in solvers.names()}


def STARTS(name: str) -> tuple[Start, ...]:
    """What the solver's binding can do."""
    return solvers.behind(name).STARTS


def LEVELS(name: str) -> tuple[Level, ...]:
    """The accuracy levels the solver has settings for."""
    return tuple(solvers.behind(name).SETTINGS)


def SUMMARY(name: str) -> str:
    """One line for the catalogue."""
    return f"soft QP (Fossen 11.38) by {solvers.behind(name).ALGORITHM}"


def build(name: str, vehicle: Vehicle, start: Start | None = None, level: Level | None = None) -> Live:
    """Prepare ``qp-soft/<solver>``; ``start`` is ``reused`` and ``level`` the most accurate unless given."""
    solver = solvers.behind(name)
    posed = pose_soft(vehicle)
    level = level or solvers.default_level(solver)
    solve = solver.prepare(posed.qp, start or solvers.default_start(solver), level)
    return Live(FORMULATION, vehicle, posed, solve, solver.TOLERANCE[FORMULATION][level])
