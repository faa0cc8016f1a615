"""A generated kernel as an allocator: compiled, loaded, and called without Python code in between."""

import ctypes
import importlib.util
import sysconfig
from collections.abc import Callable
from functools import cache, partial
from importlib import resources
from importlib.machinery import ExtensionFileLoader
from math import nan
from pathlib import Path
from typing import Any, cast

import numpy as np

from alloc.allocation import (
    LARGEST_DEMAND,
    Allocation,
    Allocator,
    BoundedSteps,
    Status,
    checked,
    checked_many,
)
from alloc.c.call import function_name
from alloc.c.compiled import NATIVE, processor, shared_library, unloadable
from alloc.c.generate import sources
from alloc.c.recipe import Recipe
from alloc.c.side_by_side import COUNT, FLAGS, side_by_side
from alloc.errors import NotInstalled
from alloc.program import Where
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, limits_of


def bound(kernel: Recipe, vehicle: Vehicle) -> Allocator:
    """The kernel for this vehicle as an allocator; raises NotApplicable or NotInstalled.

    Calls that give no limits are answered by the C that holds the vehicle's as constants, others by the C
    that takes them; one library has both.
    """
    twin = kernel.build(vehicle)  # states the promises, and refuses what the C would not cover
    both = [sources(vehicle, kernel, faults="none", limits=limits) for limits in ("fixed", "call")]
    return native(
        shared_library(kernel.name, both[0] | both[1]),
        (function_name(vehicle, kernel.name), function_name(vehicle, kernel.name, limits="call")),
        vehicle,
        formulation=twin.formulation,
        limited=twin.limited,
        tolerance=twin.tolerance,
        worst_case_steps=twin.worst_case_steps if isinstance(twin, BoundedSteps) else None,
        levels=kernel.levels(vehicle),
        together=_Together(vehicle, kernel),
    )


def native(
    path: Path,
    functions: tuple[str, str],
    vehicle: Vehicle,
    *,
    formulation: str,
    limited: bool,
    tolerance: float,
    worst_case_steps: int | None = None,
    levels: int = 0,
    state: bool = False,
    together: Callable[[Where], int] | None = None,
) -> Allocator:
    """An allocator that a compiled library answers; raises NotInstalled where that can't be loaded.

    Parameters
    ----------
    path : the library
    functions : names of its functions that answer within the vehicle's limits, and within those of the call,
        which take the arguments of a kernel for double precision
    vehicle : whose demands they answer
    formulation, limited, tolerance, worst_case_steps : the allocator's promises
    levels : how many shares the functions write behind f
    state : whether a call changes data of the library, so that only one may run at a time
    together : gives the address of the C function that answers many demands side by side, 0 where there is
        none; asked at the first call that it can answer
    """
    library = _loaded(path)
    addresses = [ctypes.cast(library[name], ctypes.c_void_p).value for name in functions]
    objects = {
        "allocation": Allocation,
        "checked": checked,
        "checked_many": checked_many,
        "limits": at_call(vehicle, held=True),
        "limits_many": partial(limits_of, vehicle, held=True),
        "f_min": vehicle.f_min,
        "f_max": vehicle.f_max,
        "statuses": tuple(Status),
        "iterations": 0,
        "solver_s": nan,
        "no_share": (),
        "formulation": formulation,
        "limited": limited,
        "tolerance": tolerance,
        "worst_case_steps": worst_case_steps,
        "library": library,
        "together": together or _apart,
    }
    return cast(Allocator, _binding().Native(*addresses, vehicle.k, vehicle.n, levels, state, objects))


def _loaded(path: Path) -> ctypes.CDLL:
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise unloadable(path, error) from None


def _apart(limits: Where) -> int:
    """No function that answers demands side by side."""
    return 0


class _Together:
    """The libraries that answer demands side by side, each made at its first use."""

    def __init__(self, vehicle: Vehicle, kernel: Recipe) -> None:
        """Bind a kernel for a vehicle."""
        self._vehicle, self._kernel = vehicle, kernel
        self._libraries: list[ctypes.CDLL] = []  # which must live as long as their functions

    def __call__(self, limits: Where) -> int:
        """The address of the function; 0 where there is none for this kernel or compiler."""
        made = side_by_side(self._vehicle, self._kernel, limits) if processor() else {}
        if not made:
            return 0
        try:
            library = _loaded(shared_library(f"{self._kernel.name}_abreast", made, FLAGS))
        except NotInstalled:  # one demand after the other has the same answers
            return 0
        self._libraries.append(library)
        name = function_name(self._vehicle, self._kernel.name, limits=limits)
        return ctypes.cast(library[f"{name}_abreast"], ctypes.c_void_p).value or 0


@cache
def _binding() -> Any:
    """The extension module of ``binding.c``, compiled for this Python and this numpy."""
    text = (resources.files("alloc.c") / "binding.c").read_text(encoding="utf-8")
    includes = [f"-I{folder}" for folder in (sysconfig.get_path("include"), np.get_include())]
    flags = [*includes, "-O3", f"-DLARGEST_DEMAND={LARGEST_DEMAND!r}", f"-DABREAST={COUNT}"]
    flags += NATIVE if processor() else ()
    suffix = f"-numpy{np.__version__}{sysconfig.get_config_var('EXT_SUFFIX')}"
    path = shared_library("thrustbench_binding", {"binding.c": text}, flags, suffix)
    loader = ExtensionFileLoader("thrustbench_binding", str(path))
    spec = importlib.util.spec_from_loader("thrustbench_binding", loader)
    assert spec is not None  # a loader was given
    try:
        module = importlib.util.module_from_spec(spec)
        loader.exec_module(module)
    except ImportError as error:
        raise unloadable(path, error) from None
    return module
