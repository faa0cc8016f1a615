"""The mixer of ArduSub: a table of factors that knows no geometry, so it leaves out what couples axes."""

from alloc.formulations import Family, Formulation

FORMULATION = Formulation(
    name="ardusub",
    title="an autopilot's mixer, no geometry",
    meaning="is what an autopilot's table of factors makes",
    family=Family.PRACTICE,
    limited=True,
    keeps_inside=False,
)
