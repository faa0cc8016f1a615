"""Offers of the catalogue's methods beyond those of every Allocator."""

import numpy as np
import pytest

from alloc import build, load_vehicle
from alloc.allocation import BoundedSteps, TwoStage
from alloc.discovery import Entry
from alloc.formulations import Family
from tests.vehicles import with_autopilot

VEHICLE = with_autopilot(load_vehicle("ukwial"))


def test_exactly_the_methods_that_call_a_solver_from_python_offer_two_stages(entry: Entry) -> None:
    """In a solver's C the wrapper poses the demand, so there is nothing to time apart."""
    from_python = bool(entry.solver) and entry.family is not Family.GENERATED
    assert isinstance(build(entry.name, VEHICLE), TwoStage) == from_python


@pytest.mark.parametrize("off", [None, 2])
def test_a_solver_s_stage_solves_what_is_posed_with_limits_of_each_thruster(
    entry: Entry, off: int | None
) -> None:
    """Limits are of all thrusters, also where one is off: a run with a fault ended in a ValueError."""
    vehicle = VEHICLE if off is None else VEHICLE.with_fault(off)
    allocate = build(entry.name, vehicle)
    if not isinstance(allocate, TwoStage):
        return
    tau, low, high = np.array([20.0, 5.0, 3.0]), vehicle.f_min / 2, vehicle.f_max / 3
    x = allocate.solve(*allocate.pose(tau, low, high))[0]  # type: ignore[index]  # an Answer, in this package
    f = allocate(tau, low, high).f[vehicle.readiness > 0]
    unit = f[0] / x[0]
    assert x[: len(f)] * unit == pytest.approx(f, abs=1e-3 * vehicle.f_scale)


def test_nullspace_and_soft_in_python_and_in_c_bound_their_steps(entry: Entry) -> None:
    allocate = build(entry.name, VEHICLE)
    bound = allocate.worst_case_steps if isinstance(allocate, BoundedSteps) else None
    assert (bound is not None) == bool({"nullspace", "soft"} & {entry.name, entry.twin})
