"""PX4's allocation: small outputs stop, entries near 0 are dropped, axes give way one after another."""

from alloc.formulations import Family, Formulation

FORMULATION = Formulation(
    name="px4",
    title="an autopilot's allocation, axis by axis",
    meaning="is what an autopilot's desaturation makes",
    family=Family.PRACTICE,
    limited=True,
    keeps_inside=False,
)
