"""One file, one solver: a function of a QP that returns ``b -> Answer``. Found by its file name.

A module imports its binding only when a problem is prepared, and says of itself, as constants:

REQUIRES, PACKAGE : what is imported, and what pip installs for it
ALGORITHM, LICENCE : as the solver's authors state them
STARTS : the starts it offers; one that is missing is one its binding has no way to do
SETTINGS : per level, everything that is not left as the solver ships it, iteration and time caps included
TOLERANCE : per formulation and level, promised distance of x to the optimum, relative to the largest
    limit [-]: three times the worst of 10,000 hard cases (``bench.studies.solvers``), rounded up. A solver
    stops at residuals; how far x then is from the optimum depends on the problem, and a soft one, with
    slack weights in the thousands, is the worse conditioned
STATUS : what each of the solver's exit flags means; ``meaning`` raises on any other. A verdict that the
    solver itself calls inaccurate (almost, close to) is none, NOT_CONVERGED, unless SETTINGS say how close

and has ``prepare(qp, start, level)``, called once a vehicle; what it returns is called once a demand.
"""

import pkgutil
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec
from math import nan
from typing import Any, Literal, NamedTuple, Protocol, TypeVar

from alloc.allocation import FloatArray, Status
from alloc.errors import SolverError
from alloc.qp import QP

Flag = TypeVar("Flag", int, str)
Start = Literal["cold", "reused", "warm"]
"""cold: new object each call; reused: same object, new b; warm: reused, the last answer is the guess."""
Level = Literal["default", "tight"]
"""default: the solver's own settings; tight: settings for f within 1e-6 of the optimum."""

TIME_LIMIT_S = 1.0
"""Cap of one solve where a solver has one [s]: 1000 times a healthy solve, so that it ends a hang and
never decides an answer, which would then depend on the machine."""


class Answer(NamedTuple):
    """A solver's claim about one b: x in the units of the QP (not checked), in its own words otherwise."""

    x: FloatArray
    status: Status
    iterations: int = 0
    solver_s: float = nan


Solve = Callable[[FloatArray], Answer]
"""A prepared problem: b (p,) to the solver's answer."""


class Solver(Protocol):
    """What a module in this package offers."""

    REQUIRES: str
    PACKAGE: str
    ALGORITHM: str
    LICENCE: str
    STARTS: tuple[Start, ...]
    SETTINGS: Mapping[Level, Mapping[str, Any]]
    TOLERANCE: Mapping[str, Mapping[Level, float]]

    def prepare(self, qp: QP, start: Start, level: Level) -> Solve:
        """Everything that does not depend on b."""
        ...


def names() -> tuple[str, ...]:
    """Every solver there is a file for, sorted, installed or not."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def load(name: str) -> Solver:
    """The module of that name; imports no binding."""
    module: Solver = import_module(f"alloc.solvers.{name}")
    return module


def all_solvers() -> dict[str, Solver]:
    """Every solver's module by name; imports no binding."""
    return {name: load(name) for name in names()}


def missing(name: str) -> str:
    """Empty where the solver's binding is installed, else how to get it; imports nothing native."""
    solver = load(name)
    return "" if find_spec(solver.REQUIRES) else f"not installed; pip install {solver.PACKAGE}"


def default_start(solver: Solver) -> Start:
    """``reused`` where the solver has it: what a vehicle does, with nothing carried over."""
    return "reused" if "reused" in solver.STARTS else solver.STARTS[0]


def default_level(solver: Solver) -> Level:
    """The most accurate there is: most solvers' own settings miss the wrench by more than SOLVED allows."""
    return list(solver.SETTINGS)[-1]


def meaning(statuses: Mapping[Flag, Status], flag: Flag, solver: str) -> Status:
    """The status an exit flag stands for; raises SolverError for one that nobody mapped."""
    try:
        return statuses[flag]
    except KeyError:
        raise SolverError(
            f"{solver} ended with exit flag {flag!r}, unknown to alloc/solvers/{solver}.py; map it there"
        ) from None
