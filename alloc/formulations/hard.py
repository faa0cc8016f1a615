"""The least effort that meets the wrench inside the limits, or no answer (eq. 4-5)."""

from alloc.formulations import EXACT_METHODS, Family, Formulation
from alloc.qp import pose_hard

FORMULATION = Formulation(
    name="hard",
    title="the optimum, eq. 4-5",
    meaning="is the least effort within the limits, or none",
    family=Family.EXACT,
    limited=True,
    optimal=True,
    references=EXACT_METHODS,
    pose=pose_hard,
)
