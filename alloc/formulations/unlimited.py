"""f = T* tau: the least effort that meets the wrench, whatever the limits (eq. 6-10)."""

from alloc.closed_forms.linear import Linear
from alloc.formulations import Family, Formulation

FORMULATION = Formulation(
    name=Linear.formulation,
    title="no limits, eq. 6-10",
    meaning="is T* τ",
    family=Family.CLOSED_FORM,
    limited=False,
)
