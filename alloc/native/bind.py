"""A generated kernel as an allocator: compiled, loaded, and called without Python code in between."""

import ctypes
import importlib.util
import sysconfig
from functools import cache, partial
from importlib import resources
from importlib.machinery import ExtensionFileLoader
from math import nan
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
from alloc.native.compiled import processor, shared_library, unloadable
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
    path = shared_library(kernel, both[0] | both[1])
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise unloadable(path, error) from None
    names = [function_name(vehicle, kernel, limits=limits) for limits in ("fixed", "call")]
    addresses = [ctypes.cast(library[name], ctypes.c_void_p).value for name in names]
    side_by_side = _abreast(vehicle, kernel)
    addresses += [
        ctypes.cast(side_by_side[f"{name}_abreast"], ctypes.c_void_p).value if side_by_side else 0
        for name in names
    ]
    objects = {
        "allocation": Allocation,
        "checked": checked,
        "checked_many": checked_many,
        "limits": at_call(vehicle),
        "limits_many": partial(limits_of, vehicle),
        "f_min": vehicle.f_min,
        "f_max": vehicle.f_max,
        "statuses": tuple(Status),
        "iterations": 0,
        "solver_s": nan,
        "no_share": (),
        "formulation": twin.formulation,
        "limited": twin.limited,
        "tolerance": twin.tolerance,
        "worst_case_steps": twin.worst_case_steps if isinstance(twin, BoundedSteps) else None,
        "library": (library, side_by_side),
    }
    return cast(
        Allocator,
        _binding().Native(*addresses, vehicle.k, vehicle.n, recipe(kernel).levels(vehicle), objects),
    )


def _abreast(vehicle: Vehicle, kernel: str) -> ctypes.CDLL | None:
    """The library that answers demands side by side; None where there is none for this kernel or compiler."""
    sources = abreast(vehicle, kernel, "fixed") | abreast(vehicle, kernel, "call")
    if len(sources) < 2 or not (built_for := processor()):
        return None
    path = shared_library(f"{kernel}_abreast", sources, FLAGS, made_for=built_for)
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise unloadable(path, error) from None


@cache
def _binding() -> Any:
    """The extension module of ``binding.c``, compiled for this Python and this numpy."""
    text = (resources.files("alloc.native") / "binding.c").read_text(encoding="utf-8")
    includes = [f"-I{folder}" for folder in (sysconfig.get_path("include"), np.get_include())]
    built_for = processor()
    flags = [*includes, "-O3", f"-DLARGEST_DEMAND={LARGEST_DEMAND!r}", f"-DABREAST={COUNT}"]
    flags += ["-march=native"] if built_for else []
    suffix = f"-numpy{np.__version__}{sysconfig.get_config_var('EXT_SUFFIX')}"
    path = shared_library("thrustbench_binding", {"binding.c": text}, flags, suffix, built_for)
    loader = ExtensionFileLoader("thrustbench_binding", str(path))
    spec = importlib.util.spec_from_loader("thrustbench_binding", loader)
    assert spec is not None  # a loader was given
    try:
        module = importlib.util.module_from_spec(spec)
        loader.exec_module(module)
    except ImportError as error:
        raise unloadable(path, error) from None
    return module
