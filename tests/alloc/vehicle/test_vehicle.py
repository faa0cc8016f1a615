"""A vehicle made in code: its faults, what it refuses, and that its arrays can't change."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.condition import condition, magnified, promised, unevenness

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


def test_weakening_a_thruster_that_is_off_is_refused_since_its_limits_are_lost() -> None:
    off = FOUR.with_fault(2)
    with pytest.raises(VehicleError, match="four-f2: thruster 2 is off, and its limits with it; weaken"):
        off.with_fault(2, readiness=0.5)
    weak = FOUR.with_fault(2, readiness=0.5)
    assert (weak.f_min[2], weak.f_max[2]) == (-3.0, 7.0)


def test_switching_a_thruster_off_twice_changes_nothing() -> None:
    off = FOUR.with_fault(2)
    assert off.with_fault(2).name == "four-f2"
    np.testing.assert_array_equal(off.with_fault(2).readiness, [1.0, 1.0, 0.0, 1.0])


def test_readiness_is_set_not_multiplied() -> None:
    weak = FOUR.with_fault(1, 0.5).with_fault(1, 0.4)
    assert weak.readiness[1] == 0.4
    assert (weak.f_min[1], weak.f_max[1]) == (-2.0, 6.0)
    assert weak.with_fault(1).f_max[1] == 0.0


@pytest.mark.parametrize(("thruster", "readiness"), [(-1, 0.0), (4, 0.0), (0, -0.1), (0, 1.1), (0, np.nan)])
def test_a_fault_of_no_thruster_or_beyond_0_to_1_is_refused(thruster: int, readiness: float) -> None:
    with pytest.raises(VehicleError, match=r"no thruster|readiness"):
        FOUR.with_fault(thruster, readiness)


@pytest.mark.parametrize("thruster", [True, np.True_, 1.0, np.float64(1.0), None, [1], np.array([0, 1])])
def test_what_is_neither_index_nor_name_is_no_thruster(thruster: Any) -> None:
    """True beside other numbers was thruster 1."""
    with pytest.raises(VehicleError, match=r"there is no thruster .*; count from 0 to 3"):
        FOUR.with_fault(thruster)
    with pytest.raises(DemandError, match="there is no thruster"):
        FOUR.limits(blocked=[thruster])
    assert FOUR.with_fault(np.int64(1)).faults == ((1, 0.0),)


@pytest.mark.parametrize(
    "key",
    [
        "T", "H", "f_min", "f_max", "readiness", "slack_weights",
        "TP", "working", "row_lengths",
    ],
)  # fmt: skip
def test_the_arrays_of_a_vehicle_are_read_only(key: str) -> None:
    array = getattr(load_vehicle("ukwial"), key)
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 0


@pytest.mark.parametrize(
    "value", [[1.0, "a", 1.0, 1.0], [1.0, 2.0j, 0.0, 0.0], [[1.0], [1.0, 2.0]], ["1"] * 4]
)
def test_values_that_are_no_array_of_numbers_are_refused_with_their_key(value: Any) -> None:
    with pytest.raises(VehicleError, match="four: f_max is not an array of numbers") as refused:
        replace(FOUR, f_max=value)
    assert refused.value.key == "f_max"


def test_an_h_that_is_symmetric_but_for_rounding_is_kept_as_it_is() -> None:
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


def nearly_singular(vehicle: Vehicle, ratio: float) -> Vehicle:
    """The vehicle pushing that much less along all axes at once.

    No singular vector is taken: where singular values are equal, which vectors come out is the processor's.
    """
    scale = vehicle.row_lengths[:, None]
    u = np.full((vehicle.k, 1), vehicle.k**-0.5)
    A = vehicle.T / scale
    return replace(vehicle, T=(A - (1 - 1 / ratio) * u @ (u.T @ A)) * scale)


def test_shipped_vehicles_keep_the_promise_of_1e_minus_9(vehicle: Vehicle) -> None:
    assert promised(vehicle, 1e-9) == 1e-9
    assert build("nullspace", vehicle).tolerance == 1e-9


def test_weights_alone_are_even_in_the_right_units() -> None:
    vehicle = replace(load_vehicle("ukwial"), H=np.diag([1e-4, 1.0, 1e2, 1e4]))
    assert unevenness(vehicle) == pytest.approx(1.0)


def test_a_solver_s_promise_follows_weights_and_the_weakest_thruster() -> None:
    """sqrt(cond H) times the longest over the shortest column of T P; 1 where thrusters are alike."""
    ukwial = load_vehicle("ukwial")
    assert magnified(ukwial) == pytest.approx(1.0)
    uneven = replace(ukwial.with_fault(1, readiness=0.05), H=np.diag([1.0, 1.0, 1.0, 1e4]))
    assert magnified(uneven) == pytest.approx(20.0 * 100.0)
    even = build("qp/clarabel", ukwial).tolerance
    assert build("qp/clarabel", uneven).tolerance == pytest.approx(2000.0 * even)


@pytest.mark.parametrize("method", ["nullspace", "scaled"])
def test_the_exact_method_is_refused_with_the_number_where_t_all_but_loses_rank(method: str) -> None:
    vehicle = replace(nearly_singular(load_vehicle("ukwial"), 3e8), weak_limit=0.0)
    assert condition(vehicle) == pytest.approx(3e8, rel=0.3)
    with pytest.raises(
        NotApplicable,
        match=rf"condition {condition(vehicle):.2g}".replace("+", r"\+") + ", so rounding alone moves",
    ):
        build(method, vehicle)


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
def test_many_gives_each_demand_the_verdict_of_a_single_call(ratio: float, rng: np.random.Generator) -> None:
    """Demands lie from 1e-13 to 1e-5 inside and outside the edge, where rounding might decide."""
    ukwial = load_vehicle("ukwial")
    vehicle = ukwial if ratio == 1.0 else nearly_singular(ukwial, ratio)
    corners = np.where(rng.random((400, vehicle.n)) < 0.5, vehicle.f_min, vehicle.f_max)
    beyond: FloatArray = 10.0 ** rng.uniform(-13, -5, (400, 1)) * rng.choice([-1.0, 1.0], (400, 1))
    taus = corners * (1 + beyond) @ vehicle.TP.T
    allocate = build("nullspace", vehicle)
    _, status = allocate.many(taus)
    assert [allocate(tau).status for tau in taus] == status.tolist()
    assert set(status) == {Status.SOLVED, Status.INFEASIBLE}
