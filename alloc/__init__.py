"""Thrust allocation for underwater vehicles: closed forms and constrained optima, side by side."""

from alloc.allocation import (
    WRENCH_TOLERANCE,
    Allocation,
    Allocator,
    BoolArray,
    BoundedSteps,
    FloatArray,
    IndexArray,
    Status,
    StatusArray,
    TwoStage,
    answer,
    checked,
    checked_many,
)
from alloc.closed_forms.inverse import generalized_inverse
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
from alloc.formulations import Family, Formulation, find_formulation, list_formulations
from alloc.plugins import Entry, build, catalogue, find, load_plugin, prepare
from alloc.qp import QP, Posed, pose_hard, pose_soft
from alloc.qp.certificate import Certificate, certify, certify_many
from alloc.reach.attainable import (
    Label,
    Margins,
    alpha_max,
    alpha_max_lp,
    alpha_range,
    closed_form_range,
    label,
    single_axis_maxima,
)
from alloc.reach.volumes import (
    attainable_volume,
    closed_form_volume,
    safe_share,
    uniform_demands,
    worst_fault,
)
from alloc.reach.way import Way
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, limits_of, one_by_one
from alloc.vehicle.geometry import DOF, unit
from alloc.vehicle.read import list_vehicles, load_vehicle

__all__ = [
    "DOF",
    "QP",
    "WRENCH_TOLERANCE",
    "AllocError",
    "Allocation",
    "Allocator",
    "BoolArray",
    "BoundedSteps",
    "Certificate",
    "DemandError",
    "Entry",
    "Family",
    "FileError",
    "FloatArray",
    "Formulation",
    "IndexArray",
    "Label",
    "Margins",
    "NotApplicable",
    "NotInstalled",
    "Posed",
    "SolverError",
    "Status",
    "StatusArray",
    "TwoStage",
    "UnknownName",
    "Vehicle",
    "VehicleError",
    "Way",
    "alpha_max",
    "alpha_max_lp",
    "alpha_range",
    "answer",
    "at_call",
    "attainable_volume",
    "build",
    "catalogue",
    "certify",
    "certify_many",
    "checked",
    "checked_many",
    "closed_form_range",
    "closed_form_volume",
    "find",
    "find_formulation",
    "generalized_inverse",
    "label",
    "limits_of",
    "list_formulations",
    "list_vehicles",
    "load_plugin",
    "load_vehicle",
    "one_by_one",
    "pose_hard",
    "pose_soft",
    "prepare",
    "safe_share",
    "single_axis_maxima",
    "uniform_demands",
    "unit",
    "worst_fault",
]
