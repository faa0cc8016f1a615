"""Which methods of the catalogue offer more than every Allocator has."""

from alloc import build, load_vehicle
from alloc.allocation import BoundedSteps, TwoStage
from alloc.discovery import Entry
from alloc.formulations import Family

VEHICLE = load_vehicle("ukwial")


def test_exactly_the_methods_that_call_a_solver_from_python_offer_two_stages(entry: Entry) -> None:
    """In a solver's C the wrapper poses the demand, so there is nothing to time apart."""
    from_python = bool(entry.solver) and entry.family is not Family.GENERATED
    assert isinstance(build(entry.name, VEHICLE), TwoStage) == from_python


def test_only_nullspace_in_python_and_in_c_bounds_its_steps(entry: Entry) -> None:
    allocate = build(entry.name, VEHICLE)
    bound = allocate.worst_case_steps if isinstance(allocate, BoundedSteps) else None
    assert (bound is not None) == ("nullspace" in (entry.name, entry.twin))
