"""Which methods of the catalogue offer more than an Allocator must have."""

from alloc import BoundedSteps, Entry, TwoStage, build, load_vehicle

VEHICLE = load_vehicle("bluerov2-heavy")


def test_the_methods_around_a_solver_offer_its_call_alone(entry: Entry) -> None:
    assert isinstance(build(entry.name, VEHICLE), TwoStage) == entry.name.startswith("qp")


def test_the_exact_method_knows_its_worst_case_in_python_and_in_c(entry: Entry) -> None:
    allocate = build(entry.name, VEHICLE)
    bound = allocate.worst_case_steps if isinstance(allocate, BoundedSteps) else None
    assert (bound is not None) == entry.name.startswith("nullspace")
