"""Names for a method, formulation or solver of your own, beside those of ``alloc``."""

from alloc.allocation import (
    BoolArray,
    BoundedSteps,
    FloatArray,
    StatusArray,
    TwoStage,
    answer,
    checked,
    checked_many,
)
from alloc.formulations import EXACT_METHODS, Family, Formulation
from alloc.qp import QP, Posed, pose_hard, pose_soft
from alloc.reach.way import Way
from alloc.vehicle.call_limits import at_call, one_by_one

__all__ = [
    "EXACT_METHODS",
    "QP",
    "BoolArray",
    "BoundedSteps",
    "Family",
    "FloatArray",
    "Formulation",
    "Posed",
    "StatusArray",
    "TwoStage",
    "Way",
    "answer",
    "at_call",
    "checked",
    "checked_many",
    "one_by_one",
    "pose_hard",
    "pose_soft",
]
