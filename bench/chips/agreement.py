"""Whether the C on an emulated processor answers as the same method in Python does here."""

from dataclasses import dataclass

import numpy as np

from alloc import Label, Status, build
from alloc.allocation import FloatArray
from alloc.c.cases import AGREEMENT, ROUNDING, TRIES, far_off
from alloc.kernels.tolerance import MET
from alloc.rivals import load
from bench.chips.count import CallCounts
from bench.chips.kernel import Kernel
from bench.demands import DemandSet
from bench.judging.shares import misstated


@dataclass(frozen=True)
class Agreement:
    """How the answers of C and Python differ.

    Attributes
    ----------
    agrees : whether every verdict is the same, every thrust within the tolerance, or within what rounding
        explains, and every share what its thrusts deliver
    distance_rel_max : largest |f - f of Python|, relative to the largest limit or thrust [-]
    other_verdicts : demands off the boundary that one calls feasible and the other does not; of a solver's
        C: that can be met and get no thrusts, or can't be met and are called met
    misstated : answers that say shares which their thrusts do not deliver
    """

    agrees: bool
    distance_rel_max: float
    other_verdicts: int
    misstated: int = 0


def agreement(kernel: Kernel, demands: DemandSet, counted: CallCounts) -> Agreement:
    """Compare a kernel's answers with its twin's in Python; the twin of a solver's C is an exact method.

    The verdicts must be the same wherever the demand is not on the boundary of the attainable set. A solver
    may give up in place of calling a demand infeasible, and stop anywhere within its tolerance.
    """
    vehicle = demands.vehicle
    given = (demands.f_min, demands.f_max) if kernel.limits == "call" else (None, None)
    twin = build(kernel.twin, vehicle)
    F, status = twin.many(demands.taus, *given)
    clear = demands.labels != Label.BOUNDARY
    met = status != Status.INFEASIBLE
    if kernel.solver:
        answered = np.isin(counted.status, (Status.SOLVED, Status.PARTIAL))
        tolerance = load(kernel.solver).TOLERANCE["default"][kernel.scalar]
        other = np.where(met, ~answered, counted.status == Status.SOLVED)
        both = clear & answered & met
    else:
        tolerance = AGREEMENT[kernel.scalar]
        other = counted.status != status
        both = (counted.status != Status.INFEASIBLE) & met
    size = np.maximum(np.abs(F[both]).max(axis=1, initial=0.0), vehicle.f_scale)
    apart = np.abs(counted.F[both] - F[both]).max(axis=1, initial=0.0)
    near = apart <= tolerance * size
    if not kernel.solver and not near.all():
        near = apart <= tolerance * size + explained(kernel, demands, F)[both]
    wrong = int(np.count_nonzero(other & clear))
    said = np.flatnonzero(np.isin(counted.status, (Status.SOLVED, Status.PARTIAL)))
    undelivered = misstated(
        demands,
        said,
        list(counted.shares[said]),
        counted.F[said],
        twin.formulation,
        tolerance=AGREEMENT[kernel.scalar] / vehicle.n,  # demands are rounded to the scalar, T f is not
        wrench_tolerance=MET[kernel.scalar],
    )
    return Agreement(
        agrees=wrong == 0 and bool(near.all()) and not undelivered.any(),
        distance_rel_max=float((apart / size).max(initial=0.0)),
        other_verdicts=wrong,
        misstated=int(undelivered.sum()),
    )


def explained(kernel: Kernel, demands: DemandSet, F: FloatArray) -> FloatArray:
    """(N,) what rounding of its arguments, and of a way's end, does at most to an answer F (N, n) [N].

    On the edge of what can be met it may move a weak thruster by far more than an argument moved. With sigma
    the root mean square of what random signs of the rounding do, the worst signs of p arguments do sqrt(p)
    sigma, as ``alloc.c.cases`` has it for self-tests. The wrench at the end is rounded as well.
    """
    vehicle, by = demands.vehicle, ROUNDING[kernel.scalar]
    rng = np.random.default_rng(1999)
    low, high = (np.broadcast_to(side, F.shape) for side in demands.limits)
    wrench = np.maximum(np.abs(demands.taus), vehicle.wrench_scale)
    width = (low != high) * vehicle.f_scale  # zero width stays zero width
    allocate = build(kernel.twin, vehicle)
    squares, ends = np.zeros(len(F)), np.zeros(len(F))
    end = (1.0 - by) * np.nan_to_num(F) @ vehicle.TP.T
    for _ in range(TRIES):
        tau_signs, low_signs, high_signs = (
            by * rng.choice([-1.0, 1.0], one.shape) for one in (wrench, low, high)
        )
        moved, _ = allocate.many(
            demands.taus + tau_signs * wrench, low + low_signs * width, high + high_signs * width
        )
        squares += far_off(moved, F) ** 2 / TRIES
        moved, _ = allocate.many(end + tau_signs * vehicle.wrench_scale, low, high)
        ends += far_off(moved, F) ** 2 / TRIES
    largest: FloatArray = np.sqrt((vehicle.k + 2 * vehicle.n) * squares) + np.sqrt(vehicle.k * ends)
    return largest
