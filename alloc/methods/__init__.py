"""Methods: each file holds one, as ``build(vehicle, …) -> Allocator``, and is found by its file name.

An underscore in the file's name is a hyphen in the method's. The module may state constants, each optional
but the first:

FORMULATION : which optimum it answers, a name out of ``alloc.formulations`` or that of a rule of its own
FAMILY : an ``alloc.plugin.Family``, where it is not the usual one of that formulation
FOREIGN : whether calls run code that is not Python's: a solver's binding, or compiled C
STARTS, LEVELS : the starts and accuracy levels it offers; ("-",) where there is no choice
AZIMUTHS : whether it takes vehicles with thrusters that turn; False where nothing says
NAMED_ONLY : whether runs leave it out unless it is named, for a call of milliseconds
SUMMARY : one line for the catalogue, in place of the first line of the module's docstring

A method that can be C offers it by two names more, and others where they apply:

program(vehicle, limits, scalar) : what a call calculates, as an ``alloc.program.Program``
MEANINGS : what each value that its C function returns means, in words for its caller
doubt(vehicle, scalar) : share of a thrust that rounding takes beyond that of a few dozen terms [-]
AZIMUTHS_IN_C : whether ``program`` takes vehicles with thrusters that turn; False where nothing says
program_for_all(vehicle, limits, scalar) : one program for the vehicle and many faults, its ``faults``

A module that holds several methods has ``variants() -> dict[name, Variant]``, and its ``build`` takes the
variant's key first.
"""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from alloc import solvers
from alloc.errors import UnknownName
from alloc.files.modules import modules

if TYPE_CHECKING:  # most methods make no C
    from alloc.c.target import Recipe


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One of several methods that a module holds.

    Attributes
    ----------
    key : what ``build`` takes first
    summary : one line for the catalogue
    missing : how to get what it needs, empty where it can be built
    solver : the QP solver it calls, empty for none
    twin : the method whose answers it gives by other means, empty for none
    formulation : which optimum it answers; empty where the module says it
    starts, levels : the starts and accuracy levels it offers; ("-",) where there is no choice
    named_only : whether runs leave it out unless it is named
    azimuths : whether it takes vehicles with thrusters that turn; None where the module's AZIMUTHS says it
    """

    key: str
    summary: str
    missing: str = ""
    solver: str = ""
    twin: str = ""
    formulation: str = ""
    starts: tuple[str, ...] = ("-",)
    levels: tuple[str, ...] = ("-",)
    named_only: bool = False
    azimuths: bool | None = None


def by_solver(prefix: str, summary: str) -> dict[str, Variant]:
    """``prefix/<solver>`` for every file in ``alloc/solvers``, with its starts and levels."""
    return {
        f"{prefix}/{name}": Variant(
            key=name,
            summary=f"{summary} by {solver.ALGORITHM}",
            missing=solvers.missing(name),
            solver=name,
            starts=solver.STARTS,
            levels=tuple(solver.SETTINGS),
        )
        for name, solver in solvers.all_solvers().items()
    }


@cache
def recipes() -> "dict[str, Recipe]":
    """All methods that can be C, by name: those whose module has ``program``."""
    from alloc.c.target import make_recipe

    found = modules(__name__).items()
    return {name: make_recipe(name, module) for name, module in found if hasattr(module, "program")}


def recipe(name: str) -> "Recipe":
    """The kernel of the method of that name; raises UnknownName."""
    if name not in recipes():
        if name in modules(__name__)["library"].variants():  # an import would go round in a circle
            raise UnknownName(f"'{name}' is in libthrustbench; give --library in place of --method")
        raise UnknownName(f"no kernel '{name}'; there are {', '.join(recipes())}")
    return recipes()[name]
