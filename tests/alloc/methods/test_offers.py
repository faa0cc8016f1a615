"""Which methods of the catalogue offer more than every Allocator has."""

from alloc import BoundedSteps, Entry, TwoStage, build, load_vehicle

VEHICLE = load_vehicle("bluerov2-heavy")


def test_exactly_the_methods_that_call_a_solver_offer_two_stages(entry: Entry) -> None:
    assert isinstance(build(entry.name, VEHICLE), TwoStage) == bool(entry.solver)


def test_only_nullspace_in_python_and_in_c_bounds_its_steps(entry: Entry) -> None:
    allocate = build(entry.name, VEHICLE)
    bound = allocate.worst_case_steps if isinstance(allocate, BoundedSteps) else None
    assert (bound is not None) == ("nullspace" in (entry.name, entry.twin))
