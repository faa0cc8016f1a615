"""Promises as a function of the conditions of T and H: refused, raised, and alike by one call and by many."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.condition import condition, magnified, promised, unevenness


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
