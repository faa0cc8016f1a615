"""Methods with limits on vehicles made up for one difficulty each."""

import numpy as np
import pytest

from alloc import Status, build
from alloc.methods import recipe
from alloc.nullspace.structure import decompose
from alloc.program import evaluate
from tests.vehicles import made_up

PLANE = ("surge", "sway", "yaw")


@pytest.mark.parametrize(
    "method", ["clip", "shrink", "redistribute", "desaturate", "fixed-point", "nullspace", "scaled"]
)
@pytest.mark.parametrize("limit", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("size", [1e30, 1e100])
def test_the_largest_demand_gets_an_answer_inside_the_limits_or_none(
    method: str, limit: float, size: float
) -> None:
    whole = made_up([[1.0, 1.0, 0.0, 0.3], [0.0, 0.5, 1.0, 0.2]], -limit, limit)
    for vehicle in (whole, whole.with_fault(0).with_fault(1).with_fault(3)):
        allocate = build(method, vehicle)
        tau = np.array([size, -size])
        f, status, *_ = allocate(tau)
        F, statuses = allocate.many([tau])
        assert status == statuses[0] == (Status.INFEASIBLE if method == "nullspace" else Status.PARTIAL)
        if method != "nullspace":
            for thrusts in (f, F[0]):
                assert (thrusts >= vehicle.f_min).all()
                assert (thrusts <= vehicle.f_max).all()


@pytest.mark.parametrize("method", ["clip", "redistribute", "nullspace", "scaled", "qp/daqp"])
def test_a_vehicle_made_with_readiness_zero_does_without_that_thruster(method: str) -> None:
    T = [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0]]
    vehicle = made_up(T, [10.0, -5.0, -5.0], [20.0, 5.0, 5.0], readiness=[0.0, 1.0, 1.0])
    f, status, *_ = build(method, vehicle)([1.0, 1.0])
    assert status is Status.SOLVED
    assert f[0] == vehicle.f_min[0] == vehicle.f_max[0] == 0.0
    np.testing.assert_allclose(f, [0.0, 1.0, 0.0], rtol=0, atol=1e-8)


@pytest.mark.parametrize("method", ["nullspace", "scaled"])
def test_an_axis_that_thrusters_push_by_rounding_only_does_not_count(method: str) -> None:
    # cos 90 deg is 6e-17: a row of such entries, scaled to unit length, would count as an axis.
    T = [[6e-17, -3e-17, 1.2e-16, 5e-17], [1.0, 1.0, -1.0, 1.0], [0.5, -0.3, 0.2, -0.1]]
    sideways = made_up(T, -10.0, 10.0)
    assert sum(block.N.shape[1] for block in decompose(sideways).blocks) == sideways.nullity == 2
    allocate = build(method, sideways)
    status = Status.INFEASIBLE if method == "nullspace" else Status.PARTIAL
    assert allocate([5.0, 1.0, 0.0]).status is status
    assert allocate([0.0, 25.0, 0.0]).status is Status.SOLVED


def test_axes_that_a_failure_makes_one_get_the_same_shares_from_c() -> None:
    """Two levels then ask thrusters for the same step; of a few such vehicles C counted it once."""
    rng, asked = np.random.default_rng(0), 0
    for _ in range(100):
        n = int(rng.integers(4, 6))
        T = rng.integers(-2, 3, (3, n)).astype(float)
        off = int(rng.integers(n))
        T[1], T[:2, off] = T[0], (1.0, -1.0)
        levels = tuple((str(axis),) for axis in rng.permutation(PLANE))
        whole = made_up(T, -50.0, 50.0, dof=PLANE, priority=levels)
        if not np.delete(T, off, axis=1).any(axis=1).all():
            continue
        vehicle, asked = whole.with_fault(off), asked + 1
        taus = rng.uniform(-1.0, 1.0, (30, 3)) * vehicle.wrench_scale
        python = build("priority", vehicle)
        expected = [python(tau).share for tau in taus]
        got = evaluate(recipe("priority").program(vehicle), taus)
        np.testing.assert_allclose(got.share, expected, rtol=0, atol=1e-9)
    assert asked > 50


@pytest.mark.parametrize("method", ["scaled", "priority"])
@pytest.mark.parametrize("made_in_c", [False, True])
def test_last_bits_of_another_axis_take_nothing_where_no_thruster_reverses(
    method: str, made_in_c: bool
) -> None:
    """C gave none: all that thrusters which would have to reverse add up is as small as those bits."""
    T = [[1.0, 1.0, 1.0], [1.0, -1.0, 0.0], [0.0, 1.0, -1.0]]
    levels = (("sway", "yaw"), ("surge",))
    vehicle = made_up(T, 0.0, 60.0, dof=PLANE, priority=levels)
    taus = np.array([[120.0, 4e-15, -8e-16], [-4e-15, 0.0, 8e-16], [450.0, -4e-15, 0.0]])
    expected = [1.0, 1.0, 0.4]
    if made_in_c:
        share = evaluate(recipe(method).program(vehicle), taus).share
    else:
        share = np.array([build(method, vehicle)(tau).share for tau in taus])
    np.testing.assert_allclose(share[:, -1], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(share[:, 0], expected if method == "scaled" else 1.0, rtol=0, atol=1e-9)
