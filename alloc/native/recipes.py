"""The methods that there is C for: their statements, and the same method in Python."""

from collections.abc import Callable
from typing import NamedTuple

from alloc.allocation import Allocator
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.linear import Linear
from alloc.closed_forms.walsh import walsh_inverse
from alloc.errors import UnknownName
from alloc.native import exact, linear
from alloc.native.code import Table
from alloc.nullspace.allocator import Nullspace
from alloc.nullspace.allocator import exact as build_nullspace
from alloc.vehicle import Vehicle


class Recipe(NamedTuple):
    """How one method becomes C.

    Attributes
    ----------
    statements : of the function's body for a vehicle and its faults, constants in a table
    twin : the same method in Python: its promises and refusals are the C's, its answers those to agree with
    formulation : which optimum both answer
    summary : one line for the catalogue
    meanings : what each value that the function returns says, in words for whoever calls it
    """

    statements: Callable[[Vehicle, Table], list[str]]
    twin: Callable[[Vehicle], Allocator]
    formulation: str
    summary: str
    meanings: dict[int, str]


_NO_FAULT = {-1: "there is no such fault; f is left alone"}
_EXACT = {
    0: "f makes tau, inside the limits, with the least effort",
    2: "no f inside the limits makes tau, or tau holds NaN or infinity; f is left alone",
} | _NO_FAULT
_LINEAR = {
    0: "f makes tau, with the least effort; limits are not looked at, nor whether tau is finite",
    1: "a direction is lost: f makes the nearest wrench there is; limits are not looked at",
} | _NO_FAULT

RECIPES = {
    "nullspace": Recipe(
        exact.body,
        build_nullspace,
        Nullspace.formulation,
        "nullspace as C99 generated for the vehicle; exact optimum of eq. 4-5.",
        _EXACT,
    ),
    "pinv": Recipe(
        linear.pinv,
        lambda vehicle: Linear(vehicle, generalized_inverse(vehicle)),
        Linear.formulation,
        "pinv as C99 generated for the vehicle, zero entries dropped.",
        _LINEAR,
    ),
    "walsh": Recipe(
        linear.walsh,
        lambda vehicle: Linear(vehicle, walsh_inverse(vehicle)),
        Linear.formulation,
        "walsh as C99 generated for the vehicle: a few multiplications, then butterflies.",
        _LINEAR,
    ),
}


def recipe(kernel: str) -> Recipe:
    """The recipe of that name; raises UnknownName."""
    if kernel not in RECIPES:
        raise UnknownName(f"no kernel '{kernel}'; there are {', '.join(RECIPES)}")
    return RECIPES[kernel]
