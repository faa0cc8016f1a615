"""Whether the C on an emulated processor answers as the same method in Python does here."""

from dataclasses import dataclass

import numpy as np

from alloc import Label, Status, build
from alloc.native.cases import AGREEMENT
from bench.demands import DemandSet
from bench.emulation.count import CallCounts
from bench.emulation.kernel import Kernel

OSQP_TOLERANCE = 1e-2
"""A tenth of what ``qp/osqp`` promises at its defaults, relative to the largest limit [-]."""
OSQP_SOLVED = 1


@dataclass(frozen=True)
class Agreement:
    """How the answers of C and Python differ.

    Attributes
    ----------
    agrees : whether every verdict is the same and every thrust within the tolerance
    distance_rel_max : largest |f - f of Python|, relative to the largest limit or thrust [-]
    other_verdicts : demands off the boundary that one calls feasible and the other does not
    """

    agrees: bool
    distance_rel_max: float
    other_verdicts: int


def agreement(kernel: Kernel, demands: DemandSet, counted: CallCounts) -> Agreement:
    """Compare a kernel's answers with its twin's in Python; the twin of OSQP's C is an exact method.

    The verdicts must be the same wherever the demand is not on the boundary of the attainable set.
    """
    vehicle = demands.vehicle
    osqp = kernel.solver != ""
    given = (demands.f_min, demands.f_max) if kernel.limits == "call" else (None, None)
    F, status = build(kernel.twin, vehicle).many(demands.taus, *given)
    verdict = (
        np.where(counted.status == OSQP_SOLVED, Status.SOLVED, Status.INFEASIBLE) if osqp else counted.status
    )
    clear = demands.labels != Label.BOUNDARY
    # On the boundary an iterative solver may stop anywhere within its tolerance, on either side.
    compared = clear if osqp else np.ones_like(clear)
    both = compared & (verdict != Status.INFEASIBLE) & (status != Status.INFEASIBLE)
    size = np.maximum(np.abs(F[both]).max(axis=1, initial=0.0), vehicle.f_scale)
    distance = float((np.abs(counted.F[both] - F[both]).max(axis=1, initial=0.0) / size).max(initial=0.0))
    tolerance = OSQP_TOLERANCE if osqp else AGREEMENT[kernel.scalar]
    other = int(np.count_nonzero((verdict != status) & clear))
    agrees = other == 0 and distance <= tolerance
    return Agreement(agrees=agrees, distance_rel_max=distance, other_verdicts=other)
