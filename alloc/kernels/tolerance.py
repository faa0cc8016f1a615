"""Tolerances of C in either scalar, and vehicles that single precision can hold."""

from alloc.allocation import EXACT_TOLERANCE, WRENCH_TOLERANCE
from alloc.errors import NotApplicable
from alloc.nullspace import allocator as nullspace
from alloc.program import Scalar
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import condition

TOLERANCE: dict[Scalar, float] = {"double": nullspace.TOLERANCE, "float": 4e-6}
"""Excess over a limit that still counts as met, relative to the largest limit [-]. Float rounds at 6e-8; some
70 times that is left for the sums."""
MET: dict[Scalar, float] = {"double": EXACT_TOLERANCE, "float": 1e-5}
"""Most that a SOLVED wrench may miss, relative to ``wrench_scale`` [-]; in single precision some hundred
roundings."""
MET_BY_SOLVERS: dict[Scalar, float] = {scalar: max(WRENCH_TOLERANCE, met) for scalar, met in MET.items()}
"""MET of solvers' own C, which SOLVED of any method in Python may miss, too [-]."""
HELD: dict[Scalar, float] = {"double": MET["double"] / 2, "float": MET["float"] / 2}
"""Most that thrusts moved onto limits miss of their shares, relative to ``wrench_scale`` [-]: half of MET,
for rounding of sums takes some too."""
SINGLE = 2.0**-24
DOUBLE = 2.0**-53
"""Rounding of a number in single and in double precision [-]."""


def rounds(vehicle: Vehicle, scalar: Scalar) -> bool:
    """True if rounding of T* costs so much of a wrench that a second product pays."""
    unit = SINGLE if scalar == "float" else DOUBLE
    return unit * condition(vehicle) > HELD[scalar] / 10


def met_as_calculated(vehicle: Vehicle, scalar: Scalar) -> float:
    """Largest error of a SOLVED wrench by a kernel's own sums, relative to ``wrench_scale`` [-].

    In single precision rounding hides some of a miss from those sums: what it takes of T* tau, and of each of
    n products. So they may miss by so much less than MET. In double precision that is next to nothing, or
    the rules look at what T* tau misses.
    """
    hidden = SINGLE * (condition(vehicle) + vehicle.n) if scalar == "float" else 0.0
    return MET[scalar] - hidden


def check_single(vehicle: Vehicle) -> None:
    """Raise NotApplicable where rounding in single precision costs the wrench more than a quarter of MET.

    A wrench known to SINGLE leaves thrusts unsure by SINGLE times the condition of T P, and what takes them
    onto limits the wrench as much. A demand of eight thrusters is up to sqrt(8) times ``wrench_scale``, which
    takes the rest of MET (``docs/studies/near_degenerate.py``).
    """
    allowed = MET["float"] / 4
    if (lost := SINGLE * condition(vehicle)) > allowed:
        off = " and ".join(vehicle.called(i) for i, readiness in vehicle.faults if readiness == 0)
        asked = f"{vehicle.whole} without {off}" if off else vehicle.name
        cure = (
            "leave out --float, what answers for failures (--faults none)," if off else "leave out --float,"
        )
        raise NotApplicable(
            f"{asked}: T nearly loses rank, condition {condition(vehicle):.2g}, so single precision "
            f"misses wrenches by up to {lost:.1g} of what the thrusters can do, more than {allowed:g}; "
            f"{cure} or the weakest DOF"
        )
