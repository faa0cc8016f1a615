"""How many instructions an exact method takes at least, whatever else it does."""

import numpy as np

from alloc import NotApplicable, Vehicle
from alloc.discovery import find
from alloc.formulations import Family, find_formulation
from alloc.reach.edge import edge
from bench.chips.kernel import Kernel


def least_instructions(kernel: Kernel, vehicle: Vehicle) -> int | None:
    """Instructions that none may leave out: reads, writes, a comparison a facet; None if not exact.

    Every input is read (k, with limits of the call 2 n more), every thrust of a working thruster written,
    and made by an operation of its own. Of each pair of opposite facets of the attainable set it must be
    known whether the demand lies beyond: one comparison, and an operation that makes what is compared unless
    it is an input. A method that finds its facets in a table of regions would compare fewer; none here does.
    """
    if find_formulation(find(kernel.twin).formulation).family is not Family.EXACT:
        return None
    try:
        normals = edge(vehicle).normals
    except NotApplicable:  # the vehicle has too many facets to find them
        return None
    n = len(vehicle.working)
    made = np.count_nonzero(np.count_nonzero(normals, axis=1) > 1)
    return int(kernel.width + 2 * n + len(normals) + made)
