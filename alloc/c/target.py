"""Targets of generated C: a method that can be C, a vehicle, and the form that it takes."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType

import numpy as np

from alloc.allocation import Allocator, IndexArray
from alloc.errors import NotApplicable
from alloc.files.modules import check_for
from alloc.formulations import find_formulation
from alloc.kernels.tolerance import check_single
from alloc.program import Faults, Program, Scalar, Where
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import refuse_azimuths, refuse_pieces

NOT_FINITE = -2
"""Status of a kernel that checks its arguments, where one is not finite."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Recipe:
    """Functions that make C of one method.

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
    named_only : whether runs leave the method out unless it is named
    azimuths : whether the C takes vehicles with thrusters that turn, within their own polygons
    """

    name: str
    formulation: str
    build: Callable[[Vehicle], Allocator]
    make: Callable[[Vehicle, Where, Scalar], Program]
    meanings: dict[int, str]
    doubt: Callable[[Vehicle, Scalar], float]
    make_for_all: Callable[[Vehicle, Where, Scalar], Program] | None
    named_only: bool = False
    azimuths: bool = False

    def check_azimuths(self, vehicle: Vehicle, limits: Where) -> None:
        """Raise NotApplicable for thrusters that turn where the C has no polygons."""
        if not self.azimuths:
            refuse_azimuths(vehicle.azimuths, f"{self.name} in C", "its limits are a box")
        refuse_pieces(vehicle.azimuths, f"{self.name} in C")
        if limits == "call":
            refuse_azimuths(vehicle.azimuths, f"{self.name} in C with --limits call", "limits are polygons")

    def program(self, vehicle: Vehicle, limits: Where = "fixed", scalar: Scalar = "double") -> Program:
        """The method's program for a vehicle; raises NotApplicable, with the reason, where there is none."""
        return _made(self, vehicle, limits, scalar)

    def program_for_all(
        self, vehicle: Vehicle, limits: Where = "fixed", scalar: Scalar = "double"
    ) -> Program:
        """The method's program for many faults of a vehicle; raises NotApplicable as ``program`` does."""
        refuse_azimuths(vehicle.azimuths, f"{self.name} --faults all", "its limits are a box")
        if self.make_for_all is None:
            raise NotApplicable(f"{self.name}: has no one function for all faults; leave out --faults all")
        if scalar == "float":
            self.check_single(vehicle)
        return self.make_for_all(vehicle, limits, scalar)

    def subject(self, vehicle: Vehicle) -> Vehicle:
        """The vehicle whose wrench the answers are held to; see ``Formulation.subject``."""
        return find_formulation(self.formulation).subject(vehicle)

    def check_single(self, vehicle: Vehicle) -> None:
        """Raise NotApplicable where single precision loses too much of a wrench that answers are held to."""
        with_way = find_formulation(self.formulation).way
        for w, subject in vehicle.mixture if with_way else ((1.0, vehicle),):
            check_single(subject, w)

    def levels(self, vehicle: Vehicle) -> int:
        """Number of shares that the C function writes behind f."""
        return self.program(vehicle).size("share")

    @property
    def limited(self) -> bool:
        """True if the kernel compares with limits, and so checks that its arguments are finite."""
        return NOT_FINITE in self.meanings


def make_recipe(name: str, module: ModuleType) -> Recipe:
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
        named_only=getattr(module, "NAMED_ONLY", False),
        azimuths=getattr(module, "AZIMUTHS_IN_C", False),
    )


def _none(vehicle: Vehicle, scalar: Scalar) -> float:
    return 0.0


@lru_cache(maxsize=64)
def _made(kernel: Recipe, vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    kernel.check_azimuths(vehicle, limits)
    if scalar == "float":
        kernel.check_single(vehicle)
    return kernel.make(vehicle, limits, scalar)


@dataclass(frozen=True, kw_only=True)
class Target:
    """One method for one vehicle, in one of the forms of its C.

    Attributes
    ----------
    vehicle : whose numbers stand in the C
    method : how the method becomes C
    scalar : the type of all numbers
    limits : ``fixed`` where the C holds the vehicle's own, ``call`` where f_min and f_max are arguments
    faults : ``none``, or any ``one`` thruster off, in code for each, or ``all`` these in one function
    """

    vehicle: Vehicle
    method: Recipe
    scalar: Scalar = "double"
    limits: Where = "fixed"
    faults: Faults = "one"

    def __post_init__(self) -> None:
        """Raise NotApplicable for thrusters that turn."""
        self.method.check_azimuths(self.vehicle, self.limits)

    @property
    def name(self) -> str:
        """Name of the C function, and stem of its files' names."""
        return function_name(self.vehicle, self.method.name, self.scalar, self.limits)

    @property
    def levels(self) -> int:
        """Number of shares that the C function writes behind f."""
        return self.method.levels(self.vehicle)

    @property
    def failures(self) -> IndexArray:
        """The thrusters whose failure the C answers for."""
        return known_faults(self.vehicle, self.faults)

    def with_fault(self, fault: int) -> Vehicle:
        """The vehicle with a thruster off; with all of them for -1."""
        return self.vehicle if fault < 0 else self.vehicle.with_fault(fault)

    @property
    def programs(self) -> Mapping[int, Program]:
        """Programs of the whole vehicle, -1, and with each one thruster off.

        Of ``faults`` "all" one program is that of many; each has its own after which a direction is lost.
        Raises NotApplicable where the method does not cover the vehicle, or those faults.
        """
        return _programs(self)

    def parameters(self, fault: str = "int fault") -> str:
        """The parameters of the C function; see ``parameters``."""
        return parameters(self.vehicle, self.scalar, self.limits, self.levels, fault)

    def arguments(self, fault: str = "") -> str:
        """The arguments of a call; see ``arguments``."""
        return arguments(self.limits, self.levels, fault)


@lru_cache(maxsize=2)  # header, source and page ask one after the other
def _programs(target: Target) -> Mapping[int, Program]:
    method, vehicle, form = target.method, target.vehicle, (target.limits, target.scalar)
    variants = {fault: target.with_fault(fault) for fault in (-1, *target.failures.tolist())}
    one = method.program_for_all(vehicle, *form) if target.faults == "all" else None
    together = one.faults if one and len(one.faults) > 1 else ()
    return {
        fault: one if one and fault in together else method.program(variant, *form)
        for fault, variant in variants.items()
    }


def known_faults(vehicle: Vehicle, faults: Faults) -> IndexArray:
    """The thrusters whose failure the C answers for; none where nothing would be left."""
    ready = np.array(vehicle.ready, dtype=np.intp)
    return ready if faults != "none" and len(ready) > 1 else ready[:0]


def component_names(vehicle: Vehicle) -> list[str]:
    """The thruster of each thrust by name, "" without one; of one that turns with the axis of the force."""
    if not vehicle.azimuths:
        return list(vehicle.names) or [""] * vehicle.n
    ends = (" along x", " along y")
    return [
        vehicle.called(i) + end
        for i, parts in enumerate(vehicle.actuators)
        for _, end in zip(parts, ends if len(parts) > 1 else ("",), strict=True)
    ]


def function_name(vehicle: Vehicle, kernel: str, scalar: Scalar = "double", limits: Where = "fixed") -> str:
    """Name of the C function, and stem of its files' names."""
    stem = re.sub(r"\W", "_", f"{vehicle.name}_{kernel}".lower(), flags=re.ASCII)
    stem = stem if stem[0].isalpha() else f"v{stem}"
    return stem + ("_call" if limits == "call" else "") + ("_float" if scalar == "float" else "")


def parameters(vehicle: Vehicle, scalar: Scalar, limits: Where, levels: int, fault: str = "int fault") -> str:
    """The parameters of the C function, with others in place of ``fault``, or none, of one behind it."""
    names = [(f"const {scalar} tau", vehicle.k)]
    if limits == "call":
        names += [(f"const {scalar} f_min", vehicle.n), (f"const {scalar} f_max", vehicle.n)]
    arrays = [f"{name}[{size}]" for name, size in names]
    shares = [f"{scalar} share[{levels}]"] if levels else []
    return ", ".join([*arrays, *[fault] * bool(fault), f"{scalar} f[{vehicle.n}]", *shares])


def arguments(limits: Where, levels: int, fault: str = "") -> str:
    """The arguments of a call, with ``fault`` in its place where one is given."""
    given = ["tau", "f_min", "f_max"] if limits == "call" else ["tau"]
    return ", ".join([*given, *([fault] if fault else []), "f", *["share"] * (levels > 0)])
