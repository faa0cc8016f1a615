"""QP solvers: each file holds one, as ``prepare(qp, start, level)``, and is found by its file name.

``prepare`` is called once a vehicle and returns ``(b, lb, ub) -> Answer``, which is called once a demand. A
module imports its binding in ``prepare`` only. The constants that it states are those of ``Solver``, and
STATUS, the meaning of each exit flag: a verdict that the solver itself calls inaccurate (almost, close to)
means NOT_CONVERGED, unless SETTINGS say how close it is. Three more may be stated.
SHARED is the power of a weight by which thrusts get smaller units (``alloc.qp.problem``). ERRATIC is True
where the solver may refuse one problem with different statuses, so that only equations tell which is right.
SLOW is True where a call takes more than 1 ms: ``thrustbench run --quick`` leaves it out unless it is named.
"""

from collections import Counter
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from math import nan
from typing import Any, Literal, NamedTuple, NoReturn, Protocol, TypeVar

from alloc.allocation import FloatArray, Status
from alloc.errors import SolverError
from alloc.files import modules
from alloc.qp import QP
from alloc.qp.problem import SHARED

Flag = TypeVar("Flag", int, str)
Start = Literal["cold", "reused", "warm"]
"""cold: a new object each call; reused: the same object, a new b; warm: reused, guessing the last answer."""
Level = Literal["default", "tight"]
"""default: the solver's own settings; tight: settings for f within 1e-6 of the optimum."""

TIME_LIMIT_S = 1.0
"""Time cap of one solve, for solvers that have one [s]. It is 1000 times a healthy solve, so that it ends a
hang and never decides an answer, which would then depend on the machine."""


class Answer(NamedTuple):
    """A solver's claim about one b and its bounds, not checked.

    Attributes
    ----------
    x : (m,) the solution, in the units of the QP
    status : what the solver's exit flag means
    iterations : the solver's own count
    solver_s : the solver's own clock [s], NaN where it has none
    """

    x: FloatArray
    status: Status
    iterations: int = 0
    solver_s: float = nan


Solve = Callable[[FloatArray, FloatArray, FloatArray], Answer]
"""A prepared problem: function of b (p,), lb and ub (q,) that returns the solver's answer.

lb and ub are the bounds of the q variables that have bounds (``QP.bounded``), finite where the problem's are.
Bounds that are the same arrays as in the last call have not changed, and cost nothing to hand over again."""


class Solver(Protocol):
    """Interface of a module in this package.

    Attributes
    ----------
    REQUIRES : name of the module that is imported
    PACKAGE : name of the package that pip installs for it
    VERSION : of that package, for which the file was written
    ALGORITHM, LICENCE : as the solver's authors state them
    STARTS : the starts that its binding can do
    SETTINGS : by level, all that differs from what the solver ships, and its iteration and time caps
    TOLERANCE : by formulation and level, promised distance of x to the optimum, relative to the largest
        limit [-]: three times the worst of 10,000 hard cases (``docs/studies/solvers.py``), rounded up. A
        solver stops at residuals, and how far x then is from the optimum depends on the problem: the soft
        one, with slack weights in the thousands, is worse conditioned
    """

    REQUIRES: str
    PACKAGE: str
    VERSION: str
    ALGORITHM: str
    LICENCE: str
    STARTS: tuple[Start, ...]
    SETTINGS: Mapping[Level, Mapping[str, Any]]
    TOLERANCE: Mapping[str, Mapping[Level, float]]

    def prepare(self, qp: QP, start: Start, level: Level) -> Solve:
        """Everything that depends neither on b nor on the bounds."""
        ...


def names() -> tuple[str, ...]:
    """Names of the solvers that have a file, sorted, installed or not."""
    return tuple(modules.names(__name__))


def load(name: str) -> Solver:
    """The module of the solver of that name; imports no binding."""
    found: Solver = modules.module(__name__, name)
    return found


def shared(name: str) -> float:
    """SHARED of the solver of that name, or the usual one; what ``pose`` takes by that name."""
    return float(getattr(load(name), "SHARED", SHARED))


def is_erratic(name: str) -> bool:
    """True if the solver of that name may return different statuses for one and the same problem."""
    return bool(getattr(load(name), "ERRATIC", False))


def slow() -> tuple[str, ...]:
    """Names of the solvers that state SLOW."""
    return tuple(name for name in names() if getattr(load(name), "SLOW", False))


def all_solvers() -> dict[str, Solver]:
    """Every solver's module by name; imports no binding."""
    return {name: load(name) for name in names()}


def missing(name: str) -> str:
    """Command that installs the solver's binding, empty where it is installed; imports nothing native."""
    solver = load(name)
    return "" if find_spec(solver.REQUIRES) else f"not installed; pip install {solver.PACKAGE}"


MOVED = (AttributeError, ImportError, TypeError)
"""Exceptions with which Python meets an interface that is not where it was."""


def refuse_interface(name: str, error: Exception) -> NoReturn:
    """Raise SolverError with the version seen and the version known, or ``error`` where both are the same.

    Call it where one of MOVED comes out of a solver's file.
    """
    from importlib.metadata import PackageNotFoundError, version

    solver = load(name)
    try:
        seen = version(solver.PACKAGE)
    except PackageNotFoundError:  # a module without metadata, put on the path by hand
        seen = "of no version"
    if seen == solver.VERSION:
        raise error
    raise SolverError(
        f"{name}: {solver.PACKAGE} is {seen}, expected {solver.VERSION}, as its interface has moved"
        f" ({type(error).__name__}: {str(error)[:60]}); pip install '{solver.PACKAGE}=={solver.VERSION}'"
    ) from error


def default_start(solver: Solver) -> Start:
    """``reused`` where the solver has it: a vehicle keeps one solver object and carries no answer over."""
    return "reused" if "reused" in solver.STARTS else solver.STARTS[0]


def default_level(solver: Solver) -> Level:
    """The most accurate level: most solvers' own settings miss the wrench by more than SOLVED allows."""
    return list(solver.SETTINGS)[-1]


disbelieved: Counter[str] = Counter()
"""Claims of solvers that were not believed in this process, and how often each was made: exit flags without a
meaning in STATUS, and INFEASIBLE where the demand can be met. A run's record keeps it."""


def meaning(statuses: Mapping[Flag, Status], flag: Flag, solver: str) -> Status:
    """The status that an exit flag stands for: NOT_CONVERGED for one missing from ``statuses``, and counted.

    A control loop must not end because a solver got a new flag; alloc/solvers/<solver>.py should map it.
    """
    try:
        return statuses[flag]
    except KeyError:
        disbelieved[f"{solver}: exit flag {flag!r}, which is not mapped"] += 1
        return Status.NOT_CONVERGED
