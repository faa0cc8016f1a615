"""The scaled generalized inverse by groups of axes: it leaves out what couples them, inside limits too."""

from alloc.formulations import Family, Formulation

FORMULATION = Formulation(
    name="group-scaling",
    title="a rule within limits, its groups uncoupled",
    meaning="is a rule of practice",
    family=Family.PRACTICE,
    limited=True,
    keeps_inside=False,
)
