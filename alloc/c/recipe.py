"""A method that can be C: what its module says of it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType

from alloc.allocation import Allocator
from alloc.errors import NotApplicable
from alloc.files.modules import check_for
from alloc.kernels.tolerance import check_single
from alloc.program import Program, Scalar, Where
from alloc.vehicle import Vehicle


@dataclass(frozen=True, eq=False, kw_only=True)
class Recipe:
    """How one method becomes C.

    Attributes
    ----------
    name : of the method
    formulation : which optimum it answers
    build : the method in Python: the C has its promises and refusals, and must agree with its answers
    make : function of a vehicle with its faults, where limits are and the scalar; returns the program
    meanings : what each value that the C function returns means, in words for its caller
    doubt : function of the vehicle with its faults and the scalar; share of a thrust that rounding takes
        beyond that of a few dozen terms [-]
    make_for_all : the same for one program of many faults, which ``Program.faults`` names; None where the
        method has none
    """

    name: str
    formulation: str
    build: Callable[[Vehicle], Allocator]
    make: Callable[[Vehicle, Where, Scalar], Program]
    meanings: dict[int, str]
    doubt: Callable[[Vehicle, Scalar], float]
    make_for_all: Callable[[Vehicle, Where, Scalar], Program] | None

    def program(self, vehicle: Vehicle, limits: Where = "fixed", scalar: Scalar = "double") -> Program:
        """The method's program for a vehicle; raises NotApplicable, with the reason, where there is none."""
        return _made(self, vehicle, limits, scalar)

    def program_for_all(
        self, vehicle: Vehicle, limits: Where = "fixed", scalar: Scalar = "double"
    ) -> Program:
        """The method's program for many faults of a vehicle; raises NotApplicable as ``program`` does."""
        if self.make_for_all is None:
            raise NotApplicable(f"{self.name}: has no one function for all faults; leave out --faults all")
        if scalar == "float":
            check_single(vehicle)
        return self.make_for_all(vehicle, limits, scalar)

    def levels(self, vehicle: Vehicle) -> int:
        """How many shares the C function writes behind f."""
        return self.program(vehicle).size("share")

    @property
    def limited(self) -> bool:
        """True if the kernel compares with limits, and so checks that its arguments are finite."""
        return NOT_FINITE in self.meanings


NOT_FINITE = -2
"""What a kernel returns that looks whether its arguments are finite, where one is not."""


def recipe_of(name: str, module: ModuleType) -> Recipe:
    """The kernel that a method's module offers by ``program``; see ``alloc.methods``."""
    check_for(module, "build", "FORMULATION", "MEANINGS")
    return Recipe(
        name=name,
        formulation=module.FORMULATION,
        build=module.build,
        make=module.program,
        meanings=module.MEANINGS,
        doubt=getattr(module, "doubt", _none),
        make_for_all=getattr(module, "program_for_all", None),
    )


def _none(vehicle: Vehicle, scalar: Scalar) -> float:
    return 0.0


@lru_cache(maxsize=64)
def _made(kernel: Recipe, vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    if scalar == "float":
        check_single(vehicle)
    return kernel.make(vehicle, limits, scalar)
