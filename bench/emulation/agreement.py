"""Whether the C on an emulated processor answers as the same method in Python does here."""

from dataclasses import dataclass

import numpy as np

from alloc import Label, Status, build
from alloc.native.cases import AGREEMENT
from alloc.rivals import load
from bench.demands import DemandSet
from bench.emulation.count import CallCounts
from bench.emulation.kernel import Kernel


@dataclass(frozen=True)
class Agreement:
    """How the answers of C and Python differ.

    Attributes
    ----------
    agrees : whether every verdict is the same and every thrust within the tolerance
    distance_rel_max : largest |f - f of Python|, relative to the largest limit or thrust [-]
    other_verdicts : demands off the boundary that one calls feasible and the other does not; of a solver's
        C: that can be met and get no thrusts, or can't be met and are called met
    """

    agrees: bool
    distance_rel_max: float
    other_verdicts: int


def agreement(kernel: Kernel, demands: DemandSet, counted: CallCounts) -> Agreement:
    """Compare a kernel's answers with its twin's in Python; the twin of a solver's C is an exact method.

    The verdicts must be the same wherever the demand is not on the boundary of the attainable set. A solver
    may give up in place of calling a demand infeasible, and stop anywhere within its tolerance.
    """
    vehicle = demands.vehicle
    given = (demands.f_min, demands.f_max) if kernel.limits == "call" else (None, None)
    F, status = build(kernel.twin, vehicle).many(demands.taus, *given)
    clear = demands.labels != Label.BOUNDARY
    met = status != Status.INFEASIBLE
    if kernel.solver:
        answered = np.isin(counted.status, (Status.SOLVED, Status.PARTIAL))
        tolerance = load(kernel.solver).TOLERANCE[kernel.scalar]
        other = np.where(met, ~answered, counted.status == Status.SOLVED)
        both = clear & answered & met
    else:
        tolerance = AGREEMENT[kernel.scalar]
        other = counted.status != status
        both = (counted.status != Status.INFEASIBLE) & met
    size = np.maximum(np.abs(F[both]).max(axis=1, initial=0.0), vehicle.f_scale)
    distance = float((np.abs(counted.F[both] - F[both]).max(axis=1, initial=0.0) / size).max(initial=0.0))
    wrong = int(np.count_nonzero(other & clear))
    return Agreement(
        agrees=wrong == 0 and distance <= tolerance, distance_rel_max=distance, other_verdicts=wrong
    )
