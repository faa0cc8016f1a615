"""Thrust allocation for underwater vehicles: closed forms and constrained optima, side by side.

What a program needs stands here. What a method, formulation or solver of your own needs stands in
``alloc.plugin``; everything else is taken from the module that it lives in.
"""

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
