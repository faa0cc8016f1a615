"""Thrust allocation for underwater vehicles: closed forms and constrained optima, side by side.

What a program needs stands here. What a method, formulation or solver of your own needs stands in
``alloc.plugin``; everything else is taken from the module that it lives in.
"""

import warnings
from importlib import import_module
from typing import TYPE_CHECKING, Any

from alloc.allocation import Allocation, Allocator, Status
from alloc.discovery import build, catalogue, generate
from alloc.errors import AllocError, NotApplicable
from alloc.reach.attainable import Label, alpha_max, label
from alloc.vehicle import Vehicle
from alloc.vehicle.file import list_vehicles, load_vehicle

__all__ = [
    "AllocError",
    "Allocation",
    "Allocator",
    "Label",
    "NotApplicable",
    "Status",
    "Vehicle",
    "alpha_max",
    "build",
    "catalogue",
    "generate",
    "label",
    "list_vehicles",
    "load_vehicle",
]

MOVED = {
    "alloc.allocation": ("WRENCH_TOLERANCE", "IndexArray"),
    "alloc.closed_forms.inverse": ("generalized_inverse",),
    "alloc.discovery": ("Entry", "find", "load_plugin", "prepare"),
    "alloc.errors": (
        "DemandError",
        "FileError",
        "NotInstalled",
        "PluginError",
        "SolverError",
        "UnknownName",
        "VehicleError",
    ),
    "alloc.formulations": ("find_formulation", "list_formulations"),
    "alloc.qp.certificate": ("Certificate", "certify", "certify_many"),
    "alloc.reach.attainable": (
        "Margins",
        "alpha_max_lp",
        "alpha_range",
        "closed_form_range",
        "single_axis_maxima",
    ),
    "alloc.reach.volumes": (
        "attainable_volume",
        "closed_form_volume",
        "safe_share",
        "uniform_demands",
        "worst_fault",
    ),
    "alloc.vehicle.call_limits": ("limits_of",),
    "alloc.vehicle.geometry": ("DOF", "unit"),
}
"""Names that stood here until 0.1, with all of ``alloc.plugin``; they go on working here for one release."""

if not TYPE_CHECKING:  # with this function a type checker would accept any name

    def __getattr__(name: str) -> Any:
        moved = {**MOVED, "alloc.plugin": import_module("alloc.plugin").__all__}
        for module, names in moved.items():
            if name in names:
                warnings.warn(
                    f"alloc.{name} moves: from {module} import {name}", DeprecationWarning, stacklevel=2
                )
                return getattr(import_module(module), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
