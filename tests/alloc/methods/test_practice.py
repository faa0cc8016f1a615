"""Rules of practice behind a closed form: each rule against its definition, and where it fails."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import Label, Status, Vehicle, alpha_max, build, catalogue, label, list_vehicles, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE
from alloc.closed_forms.inverse import generalized_inverse
from alloc.kernels.fit import LEAST

RULES = ["clip", "shrink", "redistribute", "fixed-point", "desaturate", "scaled"]
ROUNDING = 1e-9
"""Relative to the largest limit: rounding of products with a condition number below 1e3."""

rules = pytest.mark.parametrize("name", RULES)
WHOLE = [load_vehicle(name) for name in list_vehicles()]
STATES = WHOLE + [v.with_fault(1) for v in WHOLE] + [v.with_fault(0, 0.4) for v in WHOLE]


def wrenches(vehicle: Vehicle, size: float = 1.0, n: int = 60) -> np.ndarray:
    rng = np.random.default_rng(7)
    return size * rng.uniform(vehicle.f_min, vehicle.f_max, (n, vehicle.n)) @ vehicle.TP.T


def miss(vehicle: Vehicle, F: np.ndarray, taus: np.ndarray) -> np.ndarray:
    return np.abs((F @ vehicle.TP.T - taus) / vehicle.wrench_scale).max(axis=1)


def test_each_rule_states_its_own_formulation():
    formulations = {entry.name: entry.formulation for entry in catalogue() if entry.name in RULES}
    assert formulations == {name: name for name in RULES}


@rules
def test_every_rule_gives_the_closed_form_where_that_fits_the_limits(name: str):
    for vehicle in STATES:
        taus = wrenches(vehicle, 0.5)
        taus = taus[label(vehicle, taus).label == Label.INACTIVE]
        F, status = build(name, vehicle).many(taus)
        assert (status == Status.SOLVED).all()
        np.testing.assert_allclose(
            F, taus @ generalized_inverse(vehicle).T, rtol=0, atol=ROUNDING * vehicle.f_scale
        )


@rules
def test_status_is_solved_exactly_where_the_wrench_is_met(name: str):
    for vehicle in STATES:
        for size in (0.7, 1.5):
            taus = wrenches(vehicle, size)
            F, status = build(name, vehicle).many(taus)
            met = miss(vehicle, F, taus) <= WRENCH_TOLERANCE
            assert ((status == Status.SOLVED) == met).all()
            assert set(status[~met]) <= {Status.PARTIAL}


@rules
@pytest.mark.parametrize("size", [1e6, 1e90], ids=["1e6 times", "1e90 times"])
def test_a_demand_far_too_large_is_answered_inside_the_limits(name: str, size: float):
    vehicle = load_vehicle("bluerov2-heavy")
    allocate = build(name, vehicle)
    taus = wrenches(vehicle, size, n=5)
    F, status = allocate.many(taus)
    assert (status == Status.PARTIAL).all()
    for tau, f in zip(taus, F, strict=True):
        assert (f >= vehicle.f_min).all()
        assert (f <= vehicle.f_max).all()
        single = allocate(tau).f
        assert (single >= vehicle.f_min).all()
        assert (single <= vehicle.f_max).all()
        if size < 1e9:  # for 1e90 times, rounding of tau alone is many times a limit
            np.testing.assert_allclose(single, f, atol=1e-6)


@rules
def test_thrusters_that_can_not_reverse_never_push_backwards(name: str):
    oneway = replace(load_vehicle("nautilus"), f_min=np.zeros(8))
    F, _ = build(name, oneway).many(wrenches(load_vehicle("nautilus")))
    assert (F >= 0).all()


@rules
def test_a_demand_beyond_a_lost_rank_gets_the_nearest_wrench(name: str):
    vehicle = load_vehicle("ukwial").with_fault(0).with_fault(1)
    assert vehicle.rank == 2
    tau = 0.2 * vehicle.wrench_scale
    f, status, *_ = build(name, vehicle)(tau)
    assert status is Status.PARTIAL
    closed = generalized_inverse(vehicle) @ tau
    assert np.abs(closed).max() < vehicle.f_scale  # T* tau fits, and is what every rule gives
    np.testing.assert_allclose(f, closed, atol=1e-6 * vehicle.f_scale)


def test_clip_cuts_each_thrust_at_its_limit():
    for vehicle in STATES:
        taus = wrenches(vehicle, 1.5)
        F, _ = build("clip", vehicle).many(taus)
        closed = taus @ generalized_inverse(vehicle).T
        np.testing.assert_allclose(F, np.clip(closed, vehicle.f_min, vehicle.f_max), atol=1e-9)


def test_shrink_keeps_the_direction_of_the_wrench_and_uses_a_limit_in_full():
    for vehicle in WHOLE:
        taus = wrenches(vehicle, 1.5)
        F, status = build("shrink", vehicle).many(taus)
        closed = taus @ generalized_inverse(vehicle).T
        for f, whole, partly in zip(F, closed, status == Status.PARTIAL, strict=True):
            shares = f / whole
            assert np.ptp(shares) < 1e-9
            assert 0 < shares[0] <= 1
            if partly:
                reached = np.isclose(f, vehicle.f_max) | np.isclose(f, vehicle.f_min)
                assert reached.any()


def test_shrink_stops_everything_but_next_to_nothing_for_one_thruster_that_can_not_reverse():
    oneway = replace(load_vehicle("ukwial"), f_min=[0.0, -250.0, -250.0, -250.0])
    tau = oneway.T @ np.array([-1.0, 2.0, 3.0, 4.0])
    closed = generalized_inverse(oneway) @ tau
    assert closed[0] < -0.1
    rest = LEAST * 250.0 / -closed[0]
    np.testing.assert_allclose(build("shrink", oneway)(tau).f, [0.0, *(rest * closed[1:])], rtol=1e-9)


def test_shrink_is_continuous_where_a_thruster_that_can_not_reverse_is_asked_to():
    """Its demand x leaves s = LEAST / |x|, so a step dx takes at most the share dx / LEAST of the others."""
    oneway = replace(load_vehicle("ukwial"), f_min=[0.0, -250.0, -250.0, -250.0])
    G = generalized_inverse(oneway)
    asked = np.linspace(-1e-2, 1e-2, 2001)  # of the first thruster [N]
    to_first = oneway.TP[:, 0] / (G @ oneway.TP)[0, 0]
    others = oneway.TP @ [0.0, 100.0, 50.0, -25.0]
    taus = others + np.outer(asked - G[0] @ others, to_first)
    F, _ = build("shrink", oneway).many(taus)
    closed = taus @ G.T
    np.testing.assert_allclose(closed[:, 0], asked, atol=1e-12)
    share = np.diff(asked).max() / (LEAST * oneway.f_scale)
    most = share * np.abs(closed).max() + np.abs(np.diff(closed, axis=0)).max()
    assert np.abs(np.diff(F, axis=0)).max() <= most


def test_shrink_raises_a_thruster_that_must_always_push():
    pushing = replace(load_vehicle("ukwial"), f_min=[20.0, -250.0, -250.0, -250.0])
    f, status, *_ = build("shrink", pushing)([50.0, 0.0, 0.0])
    assert f[0] == 20.0
    assert status is Status.PARTIAL


def test_redistribute_meets_a_wrench_that_clipping_misses():
    ukwial = load_vehicle("ukwial")
    taus = wrenches(ukwial, n=200)
    taus = taus[label(ukwial, taus).label == Label.ACTIVE]
    assert len(taus) > 5
    assert (build("clip", ukwial).many(taus)[1] == Status.PARTIAL).all()
    # One degree of freedom is left: with one thruster frozen, the other three meet any wrench.
    assert (build("redistribute", ukwial).many(taus)[1] == Status.SOLVED).all()


def test_redistribute_may_freeze_too_early_and_miss_what_could_be_met():
    heavy = load_vehicle("bluerov2-heavy")
    taus = wrenches(heavy, n=2000)
    taus = taus[label(heavy, taus).label == Label.ACTIVE]
    _, status = build("redistribute", heavy).many(taus)
    assert 0 < np.count_nonzero(status == Status.PARTIAL) < 0.2 * len(taus)


def test_redistribute_freezes_at_most_every_thruster_once():
    for vehicle in STATES:
        allocate = build("redistribute", vehicle)
        passes = [allocate(tau).iterations for tau in wrenches(vehicle, 3.0)]
        assert 1 <= max(passes) <= len(vehicle.working)


def test_redistribute_works_for_more_thrusters_than_its_tables_cover():
    supply = load_vehicle("supply-vessel")
    wide = replace(
        supply,
        T=np.hstack([supply.T, 0.9 * supply.T]),
        H=np.eye(2 * supply.n),
        f_min=np.tile(supply.f_min, 2),
        f_max=np.tile(supply.f_max, 2),
        readiness=np.ones(2 * supply.n),
    )
    taus = wrenches(wide, 0.9, n=20)
    F, status = build("redistribute", wide).many(taus)
    np.testing.assert_array_equal(F, F.clip(wide.f_min, wide.f_max))
    assert (status == Status.SOLVED).any()


def test_fixed_point_minimises_wrench_error_and_effort_inside_the_limits():
    epsilon = 1e-7
    for vehicle in WHOLE:
        allocate, G = build("fixed-point", vehicle), generalized_inverse(vehicle)
        for tau in wrenches(vehicle, 1.5, n=20):
            f, _, iterations, *_ = allocate(tau)
            if iterations in (0, 100):
                continue  # 0: the closed form; 100: ended before it converged
            # Projected gradient in the metric H: a step from the optimum leads back to it.
            gradient = (1 - epsilon) * G @ (vehicle.T @ f - tau) + epsilon * f
            back = np.clip(f - gradient, vehicle.f_min, vehicle.f_max)
            assert np.abs(back - f).max() <= 2e-9 * vehicle.f_scale


def test_fixed_point_never_takes_more_than_its_stated_iterations():
    supply = load_vehicle("supply-vessel")
    allocate = build("fixed-point", supply)
    assert max(allocate(tau).iterations for tau in wrenches(supply, 1.0)) <= 100


def test_desaturate_gives_up_sway_before_it_touches_roll():
    heavy = load_vehicle("bluerov2-heavy")
    reach = alpha_max(heavy, np.eye(heavy.k))
    tau = np.zeros(heavy.k)
    tau[heavy.dof.index("sway")] = 1.5 * reach[heavy.dof.index("sway")]
    tau[heavy.dof.index("roll")] = 0.3 * reach[heavy.dof.index("roll")]
    f, status, *_ = build("desaturate", heavy)(tau)
    delivered = heavy.T @ f
    assert status is Status.PARTIAL
    assert delivered[heavy.dof.index("roll")] == pytest.approx(tau[heavy.dof.index("roll")], rel=1e-6)
    assert 0 < delivered[heavy.dof.index("sway")] < tau[heavy.dof.index("sway")]


def test_desaturate_keeps_a_share_between_0_and_1_of_each_axis():
    n_cut = 0
    for vehicle in WHOLE:
        taus = wrenches(vehicle, 1.2, n=300)
        F, status = build("desaturate", vehicle).many(taus)
        cut = status == Status.PARTIAL
        # Where the cuts alone brought every thrust inside, the wrench is tau with each axis scaled.
        closed = (F @ vehicle.T.T) @ generalized_inverse(vehicle).T
        cut &= np.abs(closed - F).max(axis=1) <= ROUNDING * vehicle.f_scale
        # A thruster that the null space does not move may be clipped without a sign of it there.
        unmoved = np.abs(np.eye(vehicle.n) - generalized_inverse(vehicle) @ vehicle.T).max(axis=1) < ROUNDING
        cut &= ~(unmoved & (F.clip(0.999 * vehicle.f_min, 0.999 * vehicle.f_max) != F)).any(axis=1)
        shares = (F[cut] @ vehicle.T.T) / taus[cut]
        assert (shares >= -1e-6).all()
        assert (shares <= 1 + 1e-6).all()
        n_cut += int(cut.sum())
    assert n_cut > 100


def test_scaled_delivers_the_largest_share_in_the_demanded_direction():
    for vehicle in STATES:
        taus = wrenches(vehicle, 2.0)
        alpha = np.minimum(1.0, alpha_max(vehicle, taus))
        F, status = build("scaled", vehicle).many(taus)
        assert (miss(vehicle, F, alpha[:, None] * taus) <= ROUNDING).all()
        assert ((status == Status.PARTIAL) == (alpha < 1 - 1e-6)).all()


def test_scaled_costs_no_more_than_any_other_rule_that_delivers_the_same_wrench():
    for vehicle in WHOLE:
        taus = wrenches(vehicle, 2.0)
        F, _ = build("scaled", vehicle).many(taus)
        best, _ = build("nullspace", vehicle).many(F @ vehicle.T.T * (1 - 1e-9))
        cost, least = (np.einsum("ij,jk,ik->i", f, vehicle.H, f) for f in (F, best))
        assert (cost <= least * (1 + 1e-6)).all()


def test_scaled_comes_as_near_as_it_can_where_thrusters_must_push_and_the_demand_is_too_small():
    """From thrusts a little inside their limits the way towards 1 N leads down to where all push least."""
    limits = {"f_min": [100.0, 100.0, -250.0, -250.0], "f_max": [250, 250, -50, -50]}
    pushing = replace(load_vehicle("ukwial"), **limits)
    f, status, _, _, share, *_ = build("scaled", pushing)([1.0, 0.0, 0.0])
    assert status is Status.PARTIAL
    np.testing.assert_allclose(f, [100, 100, -50, -50], atol=1e-9)
    assert 0 < share[0] < 1
