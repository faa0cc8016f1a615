"""The least effort for the wrench that is reached straight in each group of axes.

What the thrusters of one group can't push takes nothing from the others: a yaw that saturates does not slow
heave. The groups are the file's, or the axes that share thrusters on the vehicle without faults. Groups that
share thrusters go one after the other, as the levels of priority do.
"""

from alloc.formulations import EXACT_METHODS, EndOf, Family, Formulation
from alloc.reach.way import Way, groups, keeps
from alloc.vehicle import Vehicle


def straight_in_each_group(vehicle: Vehicle) -> Way:
    """A level a group; to the edge where none that comes later shares a thruster, and so nothing is left."""
    levels = vehicle.groups or groups(vehicle, vehicle.T)
    return Way(vehicle.strong, levels, keeps(vehicle, levels))


FORMULATION = Formulation(
    name="scaled-by-group",
    title="the optimum, direction kept in each group of axes",
    meaning="keeps its direction among axes that share thrusters",
    family=Family.EXACT,
    limited=True,
    optimal=True,
    references=EXACT_METHODS,
    reference_demands=EndOf(straight_in_each_group),
    way=straight_in_each_group,
)
