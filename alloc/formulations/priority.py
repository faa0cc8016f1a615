"""Prioritized allocation: the least effort for the wrench reached level by level, most important axes first.

The axes of the vehicle's first level go towards the demand while the others stay at rest, then those of the
second level from where the first stopped, and so on. An attainable demand may be met in part: what the axes
of one level ask for alone can be out of reach although all together are not, and a level that others follow
leaves one per cent of its way to the edge. Where a failure takes a direction away, other axes may go along
(``alloc.reach.way.OWN``). The field calls such rules prioritized allocation.
"""

from alloc.formulations import EXACT_METHODS, EndOf, Family, Formulation
from alloc.reach.way import KEEP, Way
from alloc.vehicle import Vehicle


def by_level(vehicle: Vehicle) -> Way:
    """The levels of the vehicle; each but the last leaves a little, so that the answer is continuous."""
    return Way(vehicle.strong, vehicle.priority, [KEEP] * (len(vehicle.priority) - 1) + [1.0])


FORMULATION = Formulation(
    name="priority",
    title="the optimum, level by level",
    meaning="serves the axes that matter most first",
    family=Family.EXACT,
    limited=True,
    references=EXACT_METHODS,
    reference_demands=EndOf(by_level),
    way=by_level,
)
