"""One file, one method. Each has ``build(vehicle, …) -> Allocator`` and is found by its file name.

An underscore in the file's name is a hyphen in the method's.

A module says of itself, as constants, each optional but the first:

FORMULATION : which optimum it answers, a name out of ``alloc.formulations`` or that of a rule of its own
FAMILY : an ``alloc.Family``, where it is not the usual one of that formulation
FOREIGN : whether calls run code that is not Python's: a solver's binding, or compiled C
STARTS, LEVELS : the starts and accuracy levels it offers; ("-",) where there is no choice
SUMMARY : one line for the catalogue; else the first line of the module's docstring

A module that is several methods has ``variants() -> dict[name, Variant]``, and its ``build`` takes the
variant's key first.
"""

from typing import NamedTuple

from alloc import solvers


class Variant(NamedTuple):
    """One of several methods that a module holds.

    Attributes
    ----------
    key : what ``build`` takes first
    summary : one line for the catalogue
    missing : empty where it can be built, else how to get what it needs
    solver : the QP solver it calls, empty for none
    twin : the method whose answers it gives by other means, empty for none
    formulation : which optimum it answers; empty where the module says it
    starts, levels : what it offers
    """

    key: str
    summary: str
    missing: str = ""
    solver: str = ""
    twin: str = ""
    formulation: str = ""
    starts: tuple[str, ...] = ("-",)
    levels: tuple[str, ...] = ("-",)


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
