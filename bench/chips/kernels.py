"""The C that is counted, of each method for a vehicle: generated here, the library, and solvers' own."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from alloc import Vehicle, catalogue
from alloc.allocation import FloatArray
from alloc.c import Target, arguments, sources
from alloc.errors import UnknownName
from alloc.files.textfile import write_folder
from alloc.formulations import EXACT_METHODS, Family
from alloc.library import adapter
from alloc.methods import library, recipe
from alloc.program import Faults, Scalar, Where
from alloc.rivals.wrapper import rival

SCALARS: dict[Scalar, str] = {"double": "<f8", "float": "<f4"}
"""C's name of a scalar to numpy's; every processor here is little-endian."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Kernel:
    """A C function int entry(…) and its sources.

    Attributes
    ----------
    method : label in tables, e.g. ``nullspace@native``
    twin : the method in Python whose answers it must give
    solver : whose C it is, empty for this project's own
    scalar : ``double`` or ``float``
    k, n : length of tau and of f
    limits : whether the limits stand in the C, or f_min and f_max are arguments of each call
    entry : the function's name
    declaration : C text that declares it
    arguments : how it is called, with ``tau``, ``f_min``, ``f_max``, ``f`` and ``share``, e.g. ``tau, f``
    sources : text by file name; every .c is compiled, other files are included by these
    levels : how many shares it writes, which the driver finds behind f
    prepared : whether its first call prepares what others use, as firmware does at boot; loops over what it
        prepares go round more often than there are axes or thrusters
    before : C that runs before each call, and is not counted
    idle : C that stands for ``declaration`` in the image without the kernel, where that differs
    options : the compiler's, besides those of all kernels
    library : the same C for this machine, where it is somebody's; its answers are those that are expected
    """

    method: str
    twin: str
    scalar: Scalar
    k: int
    n: int
    entry: str
    declaration: str
    arguments: str
    sources: Mapping[str, str]
    solver: str = ""
    limits: Where = "fixed"
    levels: int = 0
    prepared: bool = False
    before: str = ""
    idle: str = ""
    options: tuple[str, ...] = ()
    library: Path | None = None

    @property
    def width(self) -> int:
        """Number of a call's arguments: tau, and f_min and f_max where they are arguments."""
        return self.k + 2 * self.n if self.limits == "call" else self.k

    def calls(self, taus: FloatArray, f_min: FloatArray, f_max: FloatArray) -> FloatArray:
        """(N, width) what is given to each call: demands (N, k), with limits where they are arguments."""
        if self.limits == "fixed":
            return taus
        return np.hstack([taus, *(np.broadcast_to(side, (len(taus), self.n)) for side in (f_min, f_max))])

    @property
    def adapter(self) -> str:
        """C of ``ask_<entry>``, which the driver calls; behind tau lie limits, behind f shares."""
        return self._asks(self.declaration)

    @property
    def idle_adapter(self) -> str:
        """The same for an image without the kernel."""
        return self._asks(self.idle or self.declaration)

    def _asks(self, declaration: str) -> str:
        places = {
            "f_min": f"(tau + {self.k})",
            "f_max": f"(tau + {self.k + self.n})",
            "share": f"(f + {self.n})",
        }
        arguments = re.sub("|".join(places), lambda name: places[name[0]], self.arguments)
        before = f"    {self.before}\n" * bool(self.before)
        return (
            f'#include "board.h"\n#include "call.h"\n{declaration}\n\n'
            f"int ask_{self.entry}(const scalar *tau, scalar *f);\n"
            f"int ask_{self.entry}(const scalar *tau, scalar *f)\n"
            f"{{\n{before}    CALL({self.entry}, ({arguments}));\n}}\n"
        )

    def write(self, folder: Path) -> list[Path]:
        """Write the kernel's own sources into ``folder``; returns those to compile."""
        write_folder(folder, self.sources)
        return sorted(folder / name for name in self.sources if name.endswith(".c"))


def shapes(kernels: Sequence[Kernel]) -> str:
    """project.h, which tells the driver what calls take and answer: all kernels of one vehicle and scalar."""
    first = kernels[0]
    bits = {"double": "uint64_t", "float": "uint32_t"}[first.scalar]
    sizes = {"WIDTH": first.width, "N": first.n, "SHARES": max(kernel.levels for kernel in kernels)}
    return (
        f"typedef {first.scalar} scalar;\ntypedef {bits} scalar_bits;\n"
        f"enum {{ {', '.join(f'BOARD_{name} = {size}' for name, size in sizes.items())} }};\n"
    )


def braced(values: FloatArray) -> str:
    """A C initialiser of all values, row by row."""
    return f"{{{', '.join(repr(value) for value in values.ravel().tolist())}}}"


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
    twin = recipe(own()[method])
    return native_kernel(Target(vehicle=vehicle, method=twin, scalar=scalar, limits=limits, faults=faults))


def as_c(wanted: Iterable[str]) -> tuple[str, ...]:
    """The methods of these names that are C, each once: ``pinv`` means ``pinv@native``, as in ``codegen``."""
    named = {twin: method for method, twin in own().items()}
    return tuple(dict.fromkeys(named.get(method, method) for method in wanted))


def check(method: str) -> None:
    """Raise UnknownName for a method that has no C."""
    if method not in (known := (*methods(), *prepared())):
        raise UnknownName(f"no C is generated for method '{method}'; there is {', '.join(known)}")


def native_kernel(target: Target, files: Mapping[str, str] | None = None) -> Kernel:
    """The C that this project generates for a target; ``files`` are that C where it was made before."""
    return Kernel(
        method=f"{target.method.name}@native",
        twin=target.method.name,
        scalar=target.scalar,
        k=target.vehicle.k,
        n=target.vehicle.n,
        entry=target.name,
        declaration=f'#include "{target.name}.h"',
        arguments=target.arguments("-1"),
        sources=sources(target) if files is None else files,
        limits=target.limits,
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
