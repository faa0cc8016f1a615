"""Tolerances of C in either scalar, and vehicles that single precision can hold."""

from alloc.allocation import EXACT_TOLERANCE, WRENCH_TOLERANCE
from alloc.errors import NotApplicable
from alloc.nullspace import allocator as nullspace
from alloc.program import Scalar
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import condition

TOLERANCE: dict[Scalar, float] = {"double": nullspace.TOLERANCE, "float": 4e-6}
"""Excess over a limit that still counts as zero, over the largest limit [-]. Float rounds at 6e-8; sums are
allowed some 70 of these."""
WRENCH_ERROR: dict[Scalar, float] = {"double": EXACT_TOLERANCE, "float": 1e-5}
"""Largest error of a SOLVED wrench over ``wrench_scale`` [-]; in single precision some hundred roundings."""
SOLVER_ERROR: dict[Scalar, float] = {
    scalar: max(WRENCH_TOLERANCE, met) for scalar, met in WRENCH_ERROR.items()
}
"""WRENCH_ERROR for the C of solvers: not less than that of SOLVED in Python [-]."""
MOVED_ERROR: dict[Scalar, float] = {"double": WRENCH_ERROR["double"] / 2, "float": WRENCH_ERROR["float"] / 2}
"""Largest wrench error from moving thrusts onto limits, over ``wrench_scale`` [-]. Half of WRENCH_ERROR: the
other half is for the rounding of sums."""
SINGLE = 2.0**-24
DOUBLE = 2.0**-53
"""Rounding of a number in single and in double precision [-]."""


def needs_refinement(vehicle: Vehicle, scalar: Scalar) -> bool:
    """True if rounding of T* is large enough for a second product, tau - T x, to pay."""
    unit = SINGLE if scalar == "float" else DOUBLE
    return unit * condition(vehicle) > MOVED_ERROR[scalar] / 10


def computed_error_limit(vehicle: Vehicle, scalar: Scalar) -> float:
    """Largest error of a SOLVED wrench by a kernel's own sums, relative to ``wrench_scale`` [-].

    In single precision those sums hide the rounding of T* tau and of n products, so the limit is WRENCH_ERROR
    less that. In double precision it is negligible, or the rules compare T f with tau.
    """
    hidden = SINGLE * (condition(vehicle) + vehicle.n) if scalar == "float" else 0.0
    return WRENCH_ERROR[scalar] - hidden


def check_single(vehicle: Vehicle, w: float = 1.0) -> None:
    """Raise NotApplicable where single precision costs the wrench more than a quarter of WRENCH_ERROR.

    Rounding a wrench by SINGLE moves thrusts by up to SINGLE times the condition of T P, and the cut at the
    limits moves the wrench as much again. A demand of eight thrusters is up to sqrt(8) times
    ``wrench_scale``, which takes the rest (``docs/studies/near_degenerate.py``). Of a mixture
    (``Vehicle.mixture``) the part ``w`` of that arrives; half of it counts at least, for each answer that is
    mixed compares its own thrusts with limits.
    """
    allowed = WRENCH_ERROR["float"] / 4
    if (lost := SINGLE * condition(vehicle) * max(w, 0.5)) > allowed:
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
