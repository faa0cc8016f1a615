"""A generated kernel as an allocator: compiled, loaded, and called without Python code in between."""

import ctypes
import importlib.util
import sysconfig
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
from alloc.native.abreast import COUNT, FLAGS, abreast
from alloc.native.compiled import NATIVE, processor, shared_library, unloadable
from alloc.native.generate import function_name, sources
from alloc.native.recipes import recipe
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, limits_of


def bound(kernel: str, vehicle: Vehicle) -> Allocator:
    """The kernel of that name for this vehicle as an allocator; raises NotApplicable or NotInstalled.

    Calls that give no limits are answered by the kernel that holds the vehicle's as constants, others by the
    kernel that takes them; one library has both.
    """
    twin = recipe(kernel).twin(vehicle)  # states the promises, and refuses what the C would not cover
    both = [sources(vehicle, kernel, faults=False, limits=limits) for limits in ("fixed", "call")]
    return native(
        shared_library(kernel, both[0] | both[1]),
        (function_name(vehicle, kernel), function_name(vehicle, kernel, limits="call")),
        vehicle,
        formulation=twin.formulation,
        limited=twin.limited,
        tolerance=twin.tolerance,
        worst_case_steps=twin.worst_case_steps if isinstance(twin, BoundedSteps) else None,
        levels=recipe(kernel).levels(vehicle),
        side_by_side=_abreast(vehicle, kernel),
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
    side_by_side: Path | None = None,
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
    side_by_side : the library whose functions of these names with ``_abreast`` answer many demands
    """
    library = _loaded(path)
    addresses = [ctypes.cast(library[name], ctypes.c_void_p).value for name in functions]
    together = side_by_side and _loaded(side_by_side)
    addresses += [
        ctypes.cast(together[f"{name}_abreast"], ctypes.c_void_p).value if together else 0
        for name in functions
    ]
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
        "library": (library, together),
    }
    return cast(Allocator, _binding().Native(*addresses, vehicle.k, vehicle.n, levels, state, objects))


def _loaded(path: Path) -> ctypes.CDLL:
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise unloadable(path, error) from None


def _abreast(vehicle: Vehicle, kernel: str) -> Path | None:
    """The library that answers demands side by side; None where there is none for this kernel or compiler."""
    made = abreast(vehicle, kernel, "fixed") | abreast(vehicle, kernel, "call")
    return shared_library(f"{kernel}_abreast", made, FLAGS) if made and processor() else None


@cache
def _binding() -> Any:
    """The extension module of ``binding.c``, compiled for this Python and this numpy."""
    text = (resources.files("alloc.native") / "binding.c").read_text(encoding="utf-8")
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
