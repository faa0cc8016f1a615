"""Thrust allocation for underwater vehicles: closed forms and constrained optima, side by side."""

from alloc.allocation import (
    WRENCH_TOLERANCE,
    Allocation,
    Allocator,
    FloatArray,
    IndexArray,
    Status,
    StatusArray,
    answer,
    checked,
)
from alloc.attainable import (
    Label,
    Margins,
    alpha_max,
    alpha_max_lp,
    alpha_range,
    closed_form_range,
    label,
    single_axis_maxima,
)
from alloc.certificate import Certificate, certify, certify_many
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
from alloc.geometry import DOF
from alloc.inverse import generalized_inverse
from alloc.plugins import Entry, build, catalogue, find, load_plugin, prepare
from alloc.qp import QP, Posed, pose_hard, pose_soft
from alloc.vehicle import Vehicle
from alloc.vehicle_file import list_vehicles, load_vehicle
from alloc.volumes import attainable_volume, closed_form_volume, safe_share, uniform_demands, worst_fault

__all__ = [
    "DOF",
    "QP",
    "WRENCH_TOLERANCE",
    "AllocError",
    "Allocation",
    "Allocator",
    "Certificate",
    "DemandError",
    "Entry",
    "FileError",
    "FloatArray",
    "IndexArray",
    "Label",
    "Margins",
    "NotApplicable",
    "NotInstalled",
    "Posed",
    "SolverError",
    "Status",
    "StatusArray",
    "UnknownName",
    "Vehicle",
    "VehicleError",
    "alpha_max",
    "alpha_max_lp",
    "alpha_range",
    "answer",
    "attainable_volume",
    "build",
    "catalogue",
    "certify",
    "certify_many",
    "checked",
    "closed_form_range",
    "closed_form_volume",
    "find",
    "generalized_inverse",
    "label",
    "list_vehicles",
    "load_plugin",
    "load_vehicle",
    "pose_hard",
    "pose_soft",
    "prepare",
    "safe_share",
    "single_axis_maxima",
    "uniform_demands",
    "worst_fault",
]
