"""The scaled generalized inverse in parts: a rule that leaves out what couples them, also inside limits."""

from alloc.formulations import Family, Formulation

FORMULATION = Formulation(
    name="group-scaling",
    title="a rule within limits, its groups uncoupled",
    meaning="is a rule of practice",
    family=Family.PRACTICE,
    limited=True,
    keeps_inside=False,
)
