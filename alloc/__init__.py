"""Thrust allocation for underwater vehicles: closed forms and constrained optima, side by side."""

from alloc.allocation import Allocation, Allocator, Status
from alloc.attainable import Label, Margins, alpha_max, alpha_max_lp, alpha_range, label
from alloc.errors import (
    AllocError,
    DemandError,
    FileError,
    NotApplicable,
    NotInstalled,
    SolverError,
    UnknownName,
    VehicleError,
)
from alloc.inverse import generalized_inverse
from alloc.plugins import Entry, build, catalogue, find, load_plugin, prepare
from alloc.vehicle import Vehicle
from alloc.vehicle_file import list_vehicles, load_vehicle

__all__ = [
    "AllocError",
    "Allocation",
    "Allocator",
    "DemandError",
    "Entry",
    "FileError",
    "Label",
    "Margins",
    "NotApplicable",
    "NotInstalled",
    "SolverError",
    "Status",
    "UnknownName",
    "Vehicle",
    "VehicleError",
    "alpha_max",
    "alpha_max_lp",
    "alpha_range",
    "build",
    "catalogue",
    "find",
    "generalized_inverse",
    "label",
    "list_vehicles",
    "load_plugin",
    "load_vehicle",
    "prepare",
]
