"""A rule that keeps the current below a cap, and gives away some of what the cap allows."""

from alloc.formulations import Family, Formulation

FORMULATION = Formulation(
    name="cap-rule",
    title="a rule within limits and a cap",
    meaning="is a rule of practice",
    family=Family.PRACTICE,
    limited=True,
    keeps_inside=False,
)
