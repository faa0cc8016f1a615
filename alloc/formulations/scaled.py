"""Direct allocation: the least effort for the wrench farthest along the straight line to the demand.

From thrusts at rest (alloc.reach.edge.start) the wrench goes straight to the demand, as far as it is
attainable. Where zero thrust is allowed, that is the largest attainable share of the demand, and its
direction is kept: the wrench of direct allocation (Durham 1993).
"""

from alloc.formulations import EXACT_METHODS, EndOf, Family, Formulation
from alloc.reach.way import Way
from alloc.vehicle import Vehicle


def straight(vehicle: Vehicle) -> Way:
    """One level with all axes, which goes all the way to the edge."""
    return Way(vehicle.strong, [vehicle.dof], [1.0])


FORMULATION = Formulation(
    name="scaled",
    title="the optimum, direction kept",
    meaning="keeps its direction",
    family=Family.EXACT,
    limited=True,
    optimal=True,
    references=EXACT_METHODS,
    reference_demands=EndOf(straight),
    way=straight,
)
