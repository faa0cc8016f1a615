"""A generated kernel as an allocator: compiled, loaded, and called without Python code in between."""

import ctypes
import importlib.util
import sysconfig
from functools import cache
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
from alloc.native.compiled import shared_library, unloadable
from alloc.native.generate import function_name, sources
from alloc.native.recipes import recipe
from alloc.vehicle import Vehicle


def bound(kernel: str, vehicle: Vehicle) -> Allocator:
    """The kernel of that name for this vehicle as an allocator; raises NotApplicable or NotInstalled."""
    twin = recipe(kernel).twin(vehicle)  # states the promises, and refuses what the C would not cover
    path = shared_library(kernel, sources(vehicle, kernel, faults=False))
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise unloadable(path, error) from None
    address = ctypes.cast(library[function_name(vehicle, kernel)], ctypes.c_void_p).value
    allocator = _binding().Native(
        address=address,
        fault=-1,
        k=vehicle.k,
        n=vehicle.n,
        allocation=Allocation,
        statuses=tuple(Status),
        checked=checked,
        checked_many=checked_many,
        iterations=0,
        solver_s=nan,
        share=(),
        formulation=twin.formulation,
        limited=twin.limited,
        tolerance=twin.tolerance,
        worst_case_steps=twin.worst_case_steps if isinstance(twin, BoundedSteps) else None,
        library=library,
    )
    return cast(Allocator, allocator)


@cache
def _binding() -> Any:
    """The extension module of ``binding.c``, compiled for this Python and this numpy."""
    text = (resources.files("alloc.native") / "binding.c").read_text(encoding="utf-8")
    includes = [f"-I{folder}" for folder in (sysconfig.get_path("include"), np.get_include())]
    flags = [*includes, f"-DLARGEST_DEMAND={LARGEST_DEMAND!r}"]
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
