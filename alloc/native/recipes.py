"""The methods that can be C: the statements of each, and its twin in Python."""

from collections.abc import Callable
from dataclasses import dataclass

from alloc.allocation import Allocator
from alloc.closed_forms import clip, redistribute, shrink
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.linear import Linear
from alloc.closed_forms.walsh import walsh_inverse
from alloc.errors import UnknownName
from alloc.formulations import Formulation
from alloc.formulations.priority import FORMULATION as PRIORITY
from alloc.formulations.scaled import FORMULATION as SCALED
from alloc.native import exact, linear, rules
from alloc.native.bounds import CLimits
from alloc.native.by_level import by_level
from alloc.native.code import Scalar, Table
from alloc.nullspace.allocator import Nullspace
from alloc.nullspace.allocator import exact as build_nullspace
from alloc.nullspace.by_level import ByLevel
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import promised

Statements = Callable[[Vehicle, CLimits, Table], list[str]]
Functions = Callable[[Vehicle, Scalar], str]


def _no_functions(vehicle: Vehicle, scalar: Scalar) -> str:
    return ""


def _no_levels(vehicle: Vehicle) -> int:
    return 0


def _no_doubt(vehicle: Vehicle, scalar: Scalar) -> float:
    return 0.0


def _of_products(vehicle: Vehicle, scalar: Scalar) -> float:
    """What rounding takes of products with T* and N'H."""
    return promised(vehicle, 0.0)


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """How one method becomes C.

    Attributes
    ----------
    statements : function of a vehicle with its faults, its limits in C and a table of constants; returns the
        body's statements
    levels : function of the vehicle; returns how many shares the C function writes behind f
    functions : function of the vehicle and the scalar; returns C functions that the statements call
    doubt : function of the vehicle with its faults and the scalar; share of a thrust that rounding takes
        beyond that of a few dozen terms [-]
    twin : the method in Python: the C has its promises and refusals, and must agree with its answers
    formulation : which optimum both answer
    summary : one line for the catalogue
    meanings : what each value that the C function returns means, in words for its caller
    """

    statements: Statements
    functions: Functions = _no_functions
    levels: Callable[[Vehicle], int] = _no_levels
    doubt: Callable[[Vehicle, Scalar], float] = _no_doubt
    twin: Callable[[Vehicle], Allocator]
    formulation: str
    summary: str
    meanings: dict[int, str]


_NO_FAULT = {-1: "there is no such fault; f is left alone"}
_NOT_FINITE = {-2: "tau or a limit is NaN or infinite; f is left alone"}
_EXACT = (
    {
        0: "f makes tau, inside the limits, with the least effort",
        2: "no f inside the limits makes tau; f is left alone",
    }
    | _NO_FAULT
    | _NOT_FINITE
)
_LINEAR = {
    0: "f makes tau, with the least effort; limits are not looked at, nor whether tau is finite",
    1: "a direction is lost: f makes the nearest wrench there is; limits are not looked at",
} | _NO_FAULT

_RULE = (
    {
        0: "f makes tau, inside the limits",
        1: "f lies inside the limits, but makes tau in part only",
        2: "limits cross: f_min is above f_max for a thruster that is not off; f is left alone",
    }
    | _NO_FAULT
    | {-2: "tau or a limit is NaN, infinite or too large to add up; f is left alone"}
)


def _rule(
    name: str,
    twin: Callable[[Vehicle], Allocator],
    statements: Statements,
    functions: Functions = _no_functions,
    doubt: Callable[[Vehicle, Scalar], float] = _of_products,
) -> Recipe:
    return Recipe(
        statements=statements,
        functions=functions,
        doubt=doubt,
        twin=twin,
        formulation=name,
        summary=f"{name} as C99 generated for the vehicle; limits of the vehicle, or of each call.",
        meanings=_RULE,
    )


_BY_LEVEL = _RULE | {
    0: "f makes tau, inside the limits, with the least effort",
    1: "f lies inside the limits and makes, with the least effort, what share says of tau",
}


def _by_level(formulation: Formulation, levels: Callable[[Vehicle], int]) -> Recipe:
    return Recipe(
        statements=by_level(formulation),
        levels=levels,
        doubt=_of_products,
        twin=lambda vehicle: ByLevel(vehicle, formulation),
        formulation=formulation.name,
        summary=f"{formulation.name} as C99 generated for the vehicle.",
        meanings=_BY_LEVEL,
    )


RECIPES = {
    "nullspace": Recipe(
        statements=exact.body,
        twin=build_nullspace,
        formulation=Nullspace.formulation,
        summary="nullspace as C99 generated for the vehicle; exact optimum of eq. 4-5.",
        meanings=_EXACT,
    ),
    "pinv": Recipe(
        statements=linear.pinv,
        twin=lambda vehicle: Linear(vehicle, generalized_inverse(vehicle)),
        formulation=Linear.formulation,
        summary="pinv as C99 generated for the vehicle, zero entries dropped.",
        meanings=_LINEAR,
    ),
    "walsh": Recipe(
        statements=linear.walsh,
        twin=lambda vehicle: Linear(vehicle, walsh_inverse(vehicle)),
        formulation=Linear.formulation,
        summary="walsh as C99 generated for the vehicle: a few multiplications, then butterflies.",
        meanings=_LINEAR,
    ),
    "clip": _rule(clip.NAME, clip.clip, rules.clip),
    "shrink": _rule(shrink.NAME, shrink.shrink, rules.shrink),
    "redistribute": _rule(
        redistribute.NAME, redistribute.redistribute, rules.redistribute, rules.cascade, rules.cascade_doubt
    ),
    "scaled": _by_level(SCALED, lambda vehicle: 1),
    "priority": _by_level(PRIORITY, lambda vehicle: len(vehicle.priority)),
}


def recipe(kernel: str) -> Recipe:
    """The recipe of that name; raises UnknownName."""
    if kernel not in RECIPES:
        raise UnknownName(f"no kernel '{kernel}'; there are {', '.join(RECIPES)}")
    return RECIPES[kernel]
