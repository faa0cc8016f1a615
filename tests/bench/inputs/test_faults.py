"""Faults as users write them, and the vehicles that have them."""

import pytest

from alloc import load_vehicle
from alloc.errors import VehicleError
from bench.inputs.faults import EACH, GivenFault, faulty, parse_fault, with_fault


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("3", GivenFault(3)),
        ("3@0.4", GivenFault(3, 0.4)),
        ("vertical starboard", GivenFault("vertical starboard")),
        ("vertical starboard@0.4", GivenFault("vertical starboard", 0.4)),
        ("-1", GivenFault(-1)),
        ("each", EACH),
    ],
)
def test_a_fault_is_a_thruster_and_what_is_left_of_it(text: str, fault: GivenFault) -> None:
    assert parse_fault(text) == fault


@pytest.mark.parametrize("text", ["3@", "3@x", "bow@@1"])
def test_a_readiness_that_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(VehicleError, match=r"as in 3@0\.4"):
        parse_fault(text)


def test_each_is_every_working_thruster_off_in_turn() -> None:
    vehicle = load_vehicle("ukwial")
    assert [v.name for v in with_fault(vehicle, EACH)] == [f"ukwial-f{i}" for i in range(4)]
    assert [v.name for v in with_fault(vehicle.with_fault(1), EACH)] == [f"ukwial-f1-f{i}" for i in (0, 2, 3)]
    assert [v.name for v in faulty(vehicle, [None, GivenFault(2, 0.5)])] == ["ukwial", "ukwial-f2@0.5"]


def test_a_thruster_that_the_vehicle_lacks_is_refused() -> None:
    for fault in (GivenFault(-1), GivenFault(4), GivenFault("bow")):
        with pytest.raises(VehicleError):
            with_fault(load_vehicle("ukwial"), fault)
