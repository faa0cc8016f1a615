"""The least effort for the wrench that is reached straight in each group of axes.

What the thrusters of one group can't push takes nothing from the others: a yaw that saturates does not slow
heave. The groups are the file's, or the axes that share thrusters on the vehicle without faults by more than
a survey's error. The file's groups go one after the other, as the levels of priority do, where they share
thrusters. Those that only noise couples start at once: each goes as far as it could alone, and then all are
shortened by one factor until they fit.
"""

from alloc.formulations import EXACT_METHODS, EndOf, Family, Formulation
from alloc.reach.way import Levels, Way, keeps, separations
from alloc.vehicle import Vehicle


def axes_apart(vehicle: Vehicle) -> list[tuple[float, Levels]]:
    """The file's groups, or those by ``separations``."""
    return [(1.0, vehicle.groups)] if vehicle.groups else [*separations(vehicle)]


def straight_in_each_group(vehicle: Vehicle, levels: Levels = ()) -> Way:
    """A level a group, to the edge where no later one shares a thruster; together if noise couples them."""
    levels = levels or axes_apart(vehicle)[0][1]
    keep = keeps(vehicle, levels)
    if min(keep) < 1.0 and not vehicle.groups:
        return Way(vehicle.strong, levels, [1.0] * len(levels), together=True)
    return Way(vehicle.strong, levels, keep)


def is_independent(vehicle: Vehicle) -> bool:
    """True where no group shares a thruster with another."""
    return min(keeps(vehicle, axes_apart(vehicle)[0][1])) == 1.0


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
    apart=axes_apart,
    reaches_all=is_independent,
)
