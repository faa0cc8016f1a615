"""The C of each method for a vehicle: what this project generates, its library, and solvers' own."""

from collections.abc import Iterable

from alloc import Vehicle, catalogue
from alloc.c import Target, arguments, sources
from alloc.errors import UnknownName
from alloc.formulations import EXACT_METHODS, Family
from alloc.library import adapter
from alloc.methods import library, recipe
from alloc.program import Faults, Scalar, Where
from alloc.rivals.wrapper import rival
from bench.chips.kernel import Kernel


def own() -> dict[str, str]:
    """Methods that this project generates C for, each to its twin in Python."""
    return {entry.name: entry.twin for entry in catalogue() if entry.twin}


def rivals() -> dict[str, str]:
    """Methods whose C a solver's authors wrote or generate, each to the solver."""
    return {entry.name: entry.solver for entry in catalogue() if entry.family is Family.GENERATED}


def prepared() -> dict[str, str]:
    """Methods that libthrustbench answers, each to its twin in Python."""
    return {name: variant.key for name, variant in library.variants().items()}


def methods() -> tuple[str, ...]:
    """All methods that are C for one vehicle, by name."""
    return (*own(), *rivals())


def build_kernel(
    method: str, vehicle: Vehicle, scalar: Scalar, limits: Where = "fixed", faults: Faults = "one"
) -> Kernel:
    """The C of that method for a vehicle; raises UnknownName, NotInstalled or NotApplicable.

    A solver's C knows no ``faults``; the library any, whatever is asked.
    """
    check(method)
    if method in prepared():
        return _library(method, vehicle, scalar, limits)
    if method in rivals():
        return _rival(method, vehicle, scalar, limits)
    return _native(method, vehicle, scalar, limits, faults)


def as_c(wanted: Iterable[str]) -> tuple[str, ...]:
    """The methods of these names that are C, each once: ``pinv`` means ``pinv@native``, as in ``codegen``."""
    named = {twin: method for method, twin in own().items()}
    return tuple(dict.fromkeys(named.get(method, method) for method in wanted))


def check(method: str) -> None:
    """Raise UnknownName for a method that has no C."""
    if method not in (known := (*methods(), *prepared())):
        raise UnknownName(f"no C is generated for method '{method}'; there is {', '.join(known)}")


def _native(method: str, vehicle: Vehicle, scalar: Scalar, limits: Where, faults: Faults) -> Kernel:
    twin = own()[method]
    target = Target(vehicle=vehicle, method=recipe(twin), scalar=scalar, limits=limits, faults=faults)
    return Kernel(
        method=method,
        twin=twin,
        scalar=scalar,
        k=vehicle.k,
        n=vehicle.n,
        entry=target.name,
        declaration=f'#include "{target.name}.h"',
        arguments=target.arguments("-1"),
        sources=sources(target),
        limits=limits,
        levels=target.levels,
    )


def _library(method: str, vehicle: Vehicle, scalar: Scalar, limits: Where) -> Kernel:
    """libthrustbench, with room for this vehicle, and the C that prepares it and calls it."""
    twin = prepared()[method]
    recipe(twin).build(vehicle)  # refuses what the method does not cover
    name, levels = adapter.name(vehicle, twin, scalar), adapter.levels(twin, vehicle)
    return Kernel(
        method=method,
        twin=twin,
        scalar=scalar,
        k=vehicle.k,
        n=vehicle.n,
        entry=f"{name}_{limits}",
        declaration=f'#include "{name}.h"',
        arguments=arguments(limits, levels, "-1").replace("tau", f"{name}_ready(tau)"),
        sources=adapter.sized(vehicle, scalar) | adapter.adapter(vehicle, twin, scalar),
        limits=limits,
        levels=levels,
        prepared=True,
    )


def _rival(method: str, vehicle: Vehicle, scalar: Scalar, limits: Where, *, checked: bool = True) -> Kernel:
    """A solver's C as ``alloc.rivals.wrapper`` calls and checks it, or as it is."""
    solver = rivals()[method]
    made = rival(solver, vehicle, scalar, limits, checked=checked)
    return Kernel(
        method=method,
        twin=EXACT_METHODS[0],
        solver=solver,
        scalar=scalar,
        k=vehicle.k,
        n=vehicle.n,
        entry=made.entry,
        declaration=made.declaration,
        arguments=arguments(limits, 0),
        sources=made.shared | made.own,
        limits=limits,
    )


def unchecked(method: str, vehicle: Vehicle, scalar: Scalar, limits: Where = "fixed") -> Kernel:
    """The C of a rival that returns what its solver says, to show what the check costs and is worth."""
    return _rival(method, vehicle, scalar, limits, checked=False)
