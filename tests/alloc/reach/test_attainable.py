"""alpha* and labels, by facets and by linear programs, and in degenerate cases."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.optimize import linprog

from alloc import Label, Status, Vehicle, alpha_max, build, label, list_vehicles, load_vehicle
from alloc.closed_forms.inverse import generalized_inverse
from alloc.reach.attainable import alpha_max_lp, alpha_range, closed_form_range

RAY = 1e-9
"""Tolerance on alpha: HiGHS works to 1e-10 in scaled wrench, and alpha is a ratio of such numbers."""


def every_state() -> list[Vehicle]:
    """Each shipped vehicle whole, with each thruster off, with thruster 1 weakened, and with two off."""
    whole = [load_vehicle(name) for name in list_vehicles()]
    single = [v.with_fault(i) for v in whole for i in range(v.n)]
    others = [case for v in whole for case in (v.with_fault(1, 0.4), v.with_fault(0).with_fault(1))]
    return whole + single + others


def attainable_demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> np.ndarray:
    return rng.uniform(vehicle.f_min, vehicle.f_max, size=(n, vehicle.n)) @ vehicle.TP.T


def random_vehicle(seed: int, k: int, n: int, lowest: float = -1.0) -> Vehicle:
    """A vehicle of random geometry with limits of its own for each thruster."""
    rng = np.random.default_rng(seed)
    return Vehicle(
        name="random",
        dof=("surge", "sway", "heave", "roll", "pitch", "yaw")[:k],
        T=rng.normal(size=(k, n)),
        H=np.eye(n),
        f_min=rng.uniform(lowest, 0.0, size=n) if lowest < 0 else np.full(n, lowest),
        f_max=rng.uniform(lowest, 2.0, size=n).clip(min=max(lowest, 0.0)) + 0.1,
        readiness=np.ones(n),
        slack_weights=np.ones(k),
    )


def test_facets_and_linear_program_agree_on_every_vehicle_and_fault() -> None:
    rng = np.random.default_rng(1)
    for vehicle in every_state():
        spread = rng.normal(size=(4, vehicle.k)) * vehicle.wrench_scale
        inside = attainable_demands(vehicle, rng, 4)
        edge = inside / alpha_max(vehicle, -inside)[:, None]  # boundary demands of the mirrored set
        for tau in np.vstack([spread, inside, edge, np.eye(vehicle.k)]):
            expected = alpha_max_lp(vehicle, tau)
            assert alpha_max(vehicle, [tau])[0] == pytest.approx(expected, rel=RAY, abs=RAY), vehicle.name


def side_by_side(vehicle: Vehicle, taus: np.ndarray) -> np.ndarray:
    """alpha* of many demands by its definition, in one linear program that maximises their sum."""
    m, (N, k) = vehicle.n, taus.shape
    t = taus / vehicle.wrench_scale
    push = vehicle.TP * (vehicle.f_scale / vehicle.wrench_scale[:, None])
    thrusts = sparse.kron(sparse.eye_array(N), push)
    alphas = sparse.block_diag([-row[:, None] for row in t])
    limits = np.column_stack([vehicle.f_min, vehicle.f_max]) / vehicle.f_scale
    optimum = linprog(
        np.concatenate([np.zeros(N * m), -np.ones(N)]),
        A_eq=sparse.hstack([thrusts, alphas]),
        b_eq=np.zeros(N * k),
        bounds=np.vstack([np.tile(limits, (N, 1)), np.tile([-np.inf, np.inf], (N, 1))]),
        method="highs",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    assert optimum.status == 0, optimum.message
    alpha: np.ndarray = optimum.x[N * m :]
    return alpha


def test_labels_agree_with_a_linear_program_on_ten_thousand_demands() -> None:
    rng = np.random.default_rng(6)
    checked, kinds = 0, set()
    for vehicle in every_state():
        if vehicle.rank < vehicle.k:
            continue  # most demands have alpha* = 0 there; the test above covers them one by one
        n = 60
        inside = attainable_demands(vehicle, rng, n)
        delta = 10 ** rng.uniform(-5, -3, n) * rng.choice([-1, 1], n)
        edge = inside * (alpha_max(vehicle, inside) * (1 + delta))[:, None]
        beyond = inside * (alpha_max(vehicle, inside) * rng.uniform(1.02, 2, n))[:, None]
        box = rng.uniform(-1, 1, (n, vehicle.k)) * alpha_max(vehicle, np.eye(vehicle.k))
        taus = np.vstack([inside, edge, beyond, box])
        alpha = side_by_side(vehicle, taus)
        for band in (1e-3, 1e-6):
            margins = label(vehicle, taus, band)
            assert margins.alpha == pytest.approx(alpha, rel=1e-8)
            assert ((margins.label == Label.INFEASIBLE) == (alpha < 1 - band)).all()
            assert ((margins.label == Label.BOUNDARY) == (np.abs(alpha - 1) <= band)).all()
            kinds |= set(margins.label)
        checked += len(taus)
    assert checked >= 10_000
    assert kinds == set(Label)


@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 6), extra=st.integers(-1, 4))
@settings(max_examples=40, deadline=None)
def test_facets_and_linear_program_agree_on_random_geometry(seed: int, k: int, extra: int) -> None:
    vehicle = random_vehicle(seed, k, max(1, k + extra))
    rng = np.random.default_rng(seed)
    for tau in [*attainable_demands(vehicle, rng, 2), *rng.normal(size=(2, k))]:
        assert alpha_max(vehicle, [tau])[0] == pytest.approx(alpha_max_lp(vehicle, tau), rel=1e-7, abs=RAY)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_a_wrench_that_random_thrusts_push_is_attainable(seed: int) -> None:
    vehicle = random_vehicle(seed, 3, 5)
    taus = attainable_demands(vehicle, np.random.default_rng(seed), 20)
    low, high = alpha_range(vehicle, taus)
    assert (low <= 1 + RAY).all()
    assert (high >= 1 - RAY).all()


def test_alpha_of_one_thruster_is_its_limit_over_the_demand() -> None:
    vehicle = replace(random_vehicle(0, 1, 1), T=[[1.0]], f_min=[-30.0], f_max=[50.0])
    assert alpha_max(vehicle, [[10.0], [-10.0], [200.0]]).tolist() == pytest.approx([5.0, 3.0, 0.25])


def test_a_zero_demand_has_infinite_alpha() -> None:
    for vehicle in every_state():
        assert alpha_max(vehicle, np.zeros((1, vehicle.k)))[0] == np.inf
        assert alpha_max_lp(vehicle, np.zeros(vehicle.k)) == np.inf


def test_a_direction_that_no_thruster_pushes_has_alpha_zero() -> None:
    ukwial = load_vehicle("ukwial").with_fault(0).with_fault(1)
    assert ukwial.rank == 2
    reachable, unreachable = attainable_demands(ukwial, np.random.default_rng(3), 1)[0], [1.0, 1.0, 1.0]
    alpha = alpha_max(ukwial, [reachable, unreachable])
    assert alpha[0] >= 1
    assert alpha[1] == 0
    assert label(ukwial, [unreachable]).label[0] == Label.INFEASIBLE


def test_where_zero_thrust_is_forbidden_a_small_demand_is_infeasible_though_alpha_exceeds_one() -> None:
    vehicle = replace(random_vehicle(0, 1, 2), T=[[1.0, 1.0]], f_min=[2.0, 2.0], f_max=[5.0, 5.0])
    low, high = alpha_range(vehicle, [[1.0], [6.0], [-1.0]])
    assert low.tolist() == pytest.approx([4.0, 4 / 6, -10.0])
    assert high.tolist() == pytest.approx([10.0, 10 / 6, -4.0])
    expected = [Label.INFEASIBLE, Label.INACTIVE, Label.INFEASIBLE]
    assert label(vehicle, [[1.0], [6.0], [-1.0]]).label.tolist() == expected
    assert alpha_max(vehicle, [[0.0]])[0] == -np.inf
    assert alpha_max_lp(vehicle, [0.0]) == -np.inf


def test_where_no_multiple_is_attainable_alpha_is_minus_infinity() -> None:
    vehicle = replace(random_vehicle(0, 2, 2), T=np.eye(2), f_min=[2.0, 2.0], f_max=[3.0, 3.0])
    assert alpha_max(vehicle, [[1.0, 0.0]])[0] == -np.inf
    assert alpha_max_lp(vehicle, [1.0, 0.0]) == -np.inf
    assert alpha_max(vehicle, [[1.0, 1.0]])[0] == pytest.approx(3.0)


def test_a_thruster_held_at_one_thrust_shifts_the_set_and_adds_no_extent() -> None:
    vehicle = replace(random_vehicle(0, 2, 2), T=np.eye(2), f_min=[-1.0, 2.0], f_max=[1.0, 2.0])
    assert alpha_max(vehicle, [[0.5, 1.0], [1.0, 0.0]]).tolist() == pytest.approx([2.0, -np.inf])


def test_a_one_sided_thruster_that_can_not_pull_has_alpha_zero_backward() -> None:
    vehicle = replace(random_vehicle(0, 1, 1), T=[[1.0]], f_min=[0.0], f_max=[5.0])
    assert alpha_max(vehicle, [[1.0], [-1.0]]).tolist() == [5.0, 0.0]


def test_labels_follow_from_alpha_and_from_the_closed_form() -> None:
    rng = np.random.default_rng(4)
    for vehicle in every_state():
        taus = np.vstack([attainable_demands(vehicle, rng, 50), rng.normal(size=(50, vehicle.k))])
        margins = label(vehicle, taus)
        f = taus @ generalized_inverse(vehicle).T
        inside = ((f >= vehicle.f_min) & (f <= vehicle.f_max)).all(axis=1)
        for actual, alpha, fits in zip(margins.label, margins.alpha, inside, strict=True):
            if alpha < 0.999:
                assert actual == Label.INFEASIBLE
            elif alpha <= 1.001:
                assert actual == Label.BOUNDARY
            else:
                assert actual == (Label.INACTIVE if fits else Label.ACTIVE)


def test_the_closed_form_s_range_ends_at_a_limit_and_is_zero_for_an_unreachable_demand() -> None:
    rng = np.random.default_rng(8)
    for vehicle in every_state():
        taus = attainable_demands(vehicle, rng, 20)
        low, high = closed_form_range(vehicle, taus)
        for edge in (high, low):
            f = edge[:, None] * taus @ generalized_inverse(vehicle).T
            room = np.minimum(vehicle.f_max - f, f - vehicle.f_min)[:, vehicle.working].min(axis=1)
            np.testing.assert_allclose(room, 0, atol=1e-9 * vehicle.f_scale)
    lost = load_vehicle("ukwial").with_fault(0).with_fault(1)
    assert [end.tolist() for end in closed_form_range(lost, [[1.0, 1.0, 1.0]])] == [[0.0], [0.0]]


def test_clearance_is_the_distance_of_the_closed_form_to_its_nearest_limit() -> None:
    ukwial = load_vehicle("ukwial")
    f = np.array([100.0, -200.0, 240.0, 260.0])
    f = generalized_inverse(ukwial) @ ukwial.T @ f  # a minimum-norm thrust
    assert label(ukwial, [ukwial.T @ f]).clearance_N[0] == pytest.approx(250 - np.abs(f).max())


@pytest.mark.parametrize("delta", [-1e-3, -1e-4, -1e-5, 1e-5, 1e-4, 1e-3])
def test_alpha_tells_the_boundary_to_a_hundredth_of_the_narrowest_band(delta: float) -> None:
    rng = np.random.default_rng(5)
    for vehicle in every_state():
        inside = attainable_demands(vehicle, rng, 5)
        edge = inside * alpha_max(vehicle, inside)[:, None] * (1 + delta)
        assert alpha_max(vehicle, edge) == pytest.approx(1 / (1 + delta), abs=1e-7)
        assert (label(vehicle, edge, band=1e-6).label == Label.INFEASIBLE).all() == (delta > 0)
        assert (label(vehicle, edge, band=2e-3).label == Label.BOUNDARY).all()


def test_a_vehicle_of_rank_zero_attains_only_the_zero_wrench() -> None:
    T, limit = np.array([[1.0, 0.0], [0.5, 0.0]]), np.ones(2)
    lost = replace(random_vehicle(0, 2, 2), T=T, f_min=-limit, f_max=limit).with_fault(0)
    assert lost.rank == 0
    np.testing.assert_array_equal(alpha_max(lost, [[0.0, 0.0], [1.0, 0.5]]), [np.inf, 0.0])
    assert build("scaled", lost)([1.0, 0.5]).status is Status.PARTIAL


def test_a_demand_close_to_the_smallest_float_has_an_infinite_range() -> None:
    vehicle = load_vehicle("ukwial")
    taus = [[5e-324, 0.0, 0.0], [0.0, 1e-310, 0.0]]
    np.testing.assert_array_equal(alpha_range(vehicle, taus), np.outer([-np.inf, np.inf], [1, 1]))
    np.testing.assert_array_equal(closed_form_range(vehicle, taus), np.outer([-np.inf, np.inf], [1, 1]))
    assert (label(vehicle, taus).label == Label.INACTIVE).all()


def test_thrusters_that_are_nearly_off_leave_the_facets_of_the_others() -> None:
    T, limit = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0]]), np.full(3, 10.0)
    whole = replace(random_vehicle(0, 2, 3), T=T, f_min=-limit, f_max=limit)
    faint = replace(whole, readiness=[1e-10, 1e-12, 1.0])
    assert faint.rank == 1
    np.testing.assert_allclose(alpha_max(faint, [[0.0, 1.0], [1.0, 0.0]]), [10.0, 0.0])
