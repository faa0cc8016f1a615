"""The least effort for the wrench that is reached straight in each group of axes that share no thruster.

What the thrusters of one group can't push takes nothing from the others: a yaw that saturates does not slow
heave.
"""

from alloc.formulations import EXACT_METHODS, Family, Formulation, end_of
from alloc.reach.levels import groups
from alloc.reach.way import Way
from alloc.vehicle import Vehicle


def straight_in_each_group(vehicle: Vehicle) -> Way:
    """A level a group, each to the edge: no level takes from another, so none has to leave anything."""
    independent = groups(vehicle)
    return Way(vehicle, independent, [1.0] * len(independent))


FORMULATION = Formulation(
    name="scaled-by-group",
    title="the optimum, direction kept in each group of axes",
    meaning="keeps its direction among axes that share thrusters",
    family=Family.EXACT,
    limited=True,
    optimal=True,
    references=EXACT_METHODS,
    reference_demands=end_of(straight_in_each_group),
    way=straight_in_each_group,
)
