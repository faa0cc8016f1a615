"""A vehicle made in code: what it refuses, that it stays as it was made, and its faults."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from alloc import Vehicle, VehicleError, load_vehicle

FOUR = Vehicle(
    name="four",
    dof=("surge", "sway", "yaw"),
    T=np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0], [-0.5, 0.5, 1.0, -1.0]]),
    H=np.eye(4),
    f_min=np.array([-1.0, -2.0, -3.0, -4.0]),
    f_max=np.array([5.0, 6.0, 7.0, 8.0]),
    readiness=np.ones(4),
    slack_weights=np.ones(3),
)


def test_a_thruster_that_is_off_has_lost_its_limits_and_is_not_weakened_afterwards() -> None:
    off = FOUR.with_fault(2)
    with pytest.raises(VehicleError, match="four-f2: thruster 2 is off, and its limits with it; weaken"):
        off.with_fault(2, readiness=0.5)
    weak = FOUR.with_fault(2, readiness=0.5)
    assert (weak.f_min[2], weak.f_max[2]) == (-3.0, 7.0)


def test_a_thruster_fails_once() -> None:
    off = FOUR.with_fault(2)
    assert off.with_fault(2).name == "four-f2"
    np.testing.assert_array_equal(off.with_fault(2).readiness, [1.0, 1.0, 0.0, 1.0])


def test_readiness_is_set_not_multiplied() -> None:
    weak = FOUR.with_fault(1, 0.5).with_fault(1, 0.4)
    assert weak.readiness[1] == 0.4
    assert (weak.f_min[1], weak.f_max[1]) == (-2.0, 6.0)
    assert weak.with_fault(1).f_max[1] == 0.0


@pytest.mark.parametrize(("thruster", "readiness"), [(-1, 0.0), (4, 0.0), (0, -0.1), (0, 1.1), (0, np.nan)])
def test_a_fault_there_can_not_be_is_refused(thruster: int, readiness: float) -> None:
    with pytest.raises(VehicleError, match=r"no thruster|readiness"):
        FOUR.with_fault(thruster, readiness)


@pytest.mark.parametrize(
    "key",
    [
        "T", "H", "f_min", "f_max", "readiness", "slack_weights",
        "TP", "working", "row_lengths",
    ],
)  # fmt: skip
def test_nothing_about_a_vehicle_can_be_written_to(key: str) -> None:
    array = getattr(load_vehicle("ukwial"), key)
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 0


@pytest.mark.parametrize(
    "value", [[1.0, "a", 1.0, 1.0], [1.0, 2.0j, 0.0, 0.0], [[1.0], [1.0, 2.0]], ["1"] * 4]
)
def test_what_is_no_array_of_numbers_is_refused_by_its_key(value: Any) -> None:
    with pytest.raises(VehicleError, match="four: f_max is not an array of numbers") as refused:
        replace(FOUR, f_max=value)
    assert refused.value.key == "f_max"


def test_an_h_worked_out_in_floats_is_symmetric_but_for_rounding() -> None:
    R = np.linalg.qr(np.random.default_rng(0).normal(size=(4, 4)))[0]
    H = R @ (3.0 * np.eye(4)) @ R.T
    assert (H != H.T).any()
    np.testing.assert_array_equal(replace(FOUR, H=H).H, H)


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_an_h_that_is_not_symmetric_is_refused_whatever_its_size(size: float) -> None:
    H = np.diag([size, size, size, 1.0])
    H[0, 1] = 1e-9 * size
    with pytest.raises(VehicleError, match="symmetric"):
        replace(FOUR, H=H)
