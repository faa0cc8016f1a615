"""Least current for the wrench farthest along the straight line to the demand.

Thrusts of least current are seldom unique, and no equation of a QP tells them. So answers are held to limits
and share; that their current is the least is shown by a linear program (tests/alloc/methods/test_frugal.py).
"""

from alloc.formulations import Family, Formulation
from alloc.reach.way import Way
from alloc.vehicle import Vehicle


def straight(vehicle: Vehicle) -> Way:
    """One level with all axes, which goes all the way to the edge."""
    return Way(vehicle.strong, [vehicle.dof], [1.0])


FORMULATION = Formulation(
    name="frugal",
    title="the least current, direction kept",
    meaning="draws the least current",
    family=Family.EXACT,
    limited=True,
    keeps_inside=False,
    way=straight,
)
