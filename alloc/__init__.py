"""Thrust allocation for underwater vehicles: closed forms and constrained optima, side by side."""

from alloc.allocation import Allocation, Allocator, Status
from alloc.errors import (
    AllocError,
    DemandError,
    NotApplicable,
    NotInstalled,
    SolverError,
    UnknownName,
    VehicleError,
)
from alloc.plugins import Entry, build, catalogue
from alloc.vehicle import Vehicle
from alloc.vehicle_file import list_vehicles, load_vehicle

__all__ = [
    "AllocError",
    "Allocation",
    "Allocator",
    "DemandError",
    "Entry",
    "NotApplicable",
    "NotInstalled",
    "SolverError",
    "Status",
    "UnknownName",
    "Vehicle",
    "VehicleError",
    "build",
    "catalogue",
    "list_vehicles",
    "load_vehicle",
]
