"""For which vehicles the exact answer is prepared, and for which it is refused."""

from alloc.allocation import WRENCH_TOLERANCE
from alloc.errors import NotApplicable
from alloc.nullspace.allocator import TOLERANCE, Nullspace
from alloc.nullspace.region import steps_bound
from alloc.nullspace.structure import decompose
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import condition, wrench_doubt

LARGEST_DOUBT = WRENCH_TOLERANCE / 4
"""Largest excess that may count as met [-]: thrusts off by it, n up to 16, still meet a wrench."""

STEPS_LIMIT = 5000
"""Largest worst case of a block, in steps. Up to here a call may take milliseconds in Python and setting up
a tenth of a second (measured on one x86-64 core, 3 x 11); an active-set solver needs neither."""


def exact(vehicle: Vehicle, tolerance: float = TOLERANCE) -> Nullspace:
    """Prepare the exact answer.

    ``tolerance`` is the excess over a limit that still counts as met, relative to the largest limit [-], or
    what rounding leaves of it. Raises NotApplicable where that is too much for SOLVED to mean anything, and
    where a block may take more than STEPS_LIMIT steps.
    """
    if (doubt := wrench_doubt(vehicle)) > LARGEST_DOUBT:
        raise NotApplicable(
            f"{vehicle.name}: T nearly loses rank, condition {condition(vehicle):.2g}, so rounding alone "
            f"moves thrusts by {doubt:.1g} of the largest limit; leave out the weakest DOF, or use qp/daqp"
        )
    structure = decompose(vehicle)
    for block in structure.blocks:
        m, d = block.N.shape
        if (bound := steps_bound(m, d)) > STEPS_LIMIT:
            raise NotApplicable(
                f"nullspace: {m} thrusters share a {d}-dimensional null space, up to {bound} steps a call; "
                f"more than {STEPS_LIMIT} are refused, use a qp/ method"
            )
    return Nullspace(vehicle, structure, max(tolerance, doubt))
