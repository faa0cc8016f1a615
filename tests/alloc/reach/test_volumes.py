"""Volumes of the sets that a vehicle reaches, against counting and in cases worked out by hand."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from alloc import NotApplicable, Vehicle, alpha_max, list_vehicles, load_vehicle
from alloc.closed_forms.inverse import generalized_inverse
from alloc.reach.attainable import alpha_range
from alloc.reach.volumes import (
    attainable_volume,
    closed_form_volume,
    safe_share,
    uniform_demands,
    worst_fault,
)

Inside = Callable[[Vehicle, np.ndarray], np.ndarray]


def attainable(vehicle: Vehicle, taus: np.ndarray) -> np.ndarray:
    low, high = alpha_range(vehicle, taus)
    return (low <= 1) & (high >= 1)


def served(vehicle: Vehicle, taus: np.ndarray) -> np.ndarray:
    f = taus @ generalized_inverse(vehicle).T
    return ((f >= vehicle.f_min) & (f <= vehicle.f_max)).all(axis=1)


def counted(vehicle: Vehicle, inside: Inside, n: int = 60_000) -> tuple[float, float]:
    """Volume in newtons by counting random points of a box around the set, and its standard error."""
    push = vehicle.TP / vehicle.row_lengths[:, None]
    corners = np.array([push * vehicle.f_min, push * vehicle.f_max])
    low, high = corners.min(axis=0).sum(axis=1), corners.max(axis=0).sum(axis=1)
    points = np.random.default_rng(11).uniform(low, high, (n, vehicle.k))
    share = inside(vehicle, points * vehicle.row_lengths).mean()
    box = float(np.prod(high - low))
    return share * box, box * float(np.sqrt(share * (1 - share) / n))


@pytest.mark.parametrize("name", list_vehicles())
@pytest.mark.parametrize("fault", [None, 0])
@pytest.mark.parametrize(
    ("volume", "inside"), [(attainable_volume, attainable), (closed_form_volume, served)]
)
def test_exact_volumes_agree_with_counting(
    name: str, fault: int | None, volume: Callable[[Vehicle], float], inside: Inside
) -> None:
    vehicle = load_vehicle(name) if fault is None else load_vehicle(name).with_fault(fault)
    assert vehicle.rank == vehicle.k
    estimate, error = counted(vehicle, inside)
    assert error < 0.1 * estimate  # a larger error would let any volume pass
    assert volume(vehicle) == pytest.approx(estimate, abs=4 * error)


@pytest.mark.parametrize("name", list_vehicles())
@pytest.mark.parametrize("fault", [None, 1])
def test_uniform_demands_fill_the_set_evenly(name: str, fault: int | None) -> None:
    vehicle = load_vehicle(name) if fault is None else load_vehicle(name).with_fault(fault)
    n = 10_000
    taus = uniform_demands(vehicle, np.random.default_rng(12), n)
    alpha = alpha_max(vehicle, taus)
    assert (alpha >= 1 - 1e-9).all()
    # Scaling a set by s scales its volume by s^r: the share of demands with alpha* >= 1/s must be s^r …
    depth = np.sort(alpha ** -float(vehicle.rank))
    assert np.abs(depth - np.arange(1, n + 1) / n).max() < 1.95 / np.sqrt(n)  # Kolmogorov-Smirnov, 0.1 %
    # … and the share that the closed form serves must be that of its exact volume.
    exact = closed_form_volume(vehicle) / attainable_volume(vehicle)
    assert served(vehicle, taus).mean() == pytest.approx(
        exact, abs=4 * np.sqrt(exact * (1 - exact) / n) + 1e-6
    )


def test_one_thruster_an_axis_fills_the_box_of_its_limits() -> None:
    box = Vehicle(
        name="box",
        dof=("surge", "sway", "heave"),
        T=np.eye(3),
        H=np.eye(3),
        f_min=[-1.0, -2.0, 0.0],
        f_max=[2.0, 2.0, 5.0],
        readiness=np.ones(3),
        slack_weights=np.ones(3),
    )
    for volume in (attainable_volume, closed_form_volume):
        assert volume(box) == pytest.approx(3 * 4 * 5)
        assert volume(box.with_fault(0, 0.5)) == pytest.approx(3 * 4 * 5 / 2)
        assert volume(box.with_fault(1)) == pytest.approx(3 * 5)  # area in the two directions that remain


def test_at_nullity_zero_the_closed_form_serves_the_whole_attainable_volume() -> None:
    for name in list_vehicles():
        vehicle = load_vehicle(name)
        while vehicle.nullity > 0:
            vehicle = vehicle.with_fault(int(vehicle.working[0]))
        assert closed_form_volume(vehicle) == pytest.approx(attainable_volume(vehicle), rel=1e-9)


def test_the_closed_form_serves_two_thirds_of_what_the_papers_vehicle_can_do() -> None:
    # The thrusts fill a 4-cube, and null(T) is its diagonal. The thrusts T* tau are the section of the cube
    # across the diagonal, an octahedron (32/3 for half edges of 1). The attainable set is the shadow of the
    # cube along the diagonal, a rhombic dodecahedron (16).
    ukwial = load_vehicle("ukwial")
    assert closed_form_volume(ukwial) / attainable_volume(ukwial) == pytest.approx(2 / 3)


def test_limits_that_exclude_every_closed_form_thrust_leave_the_closed_form_no_volume() -> None:
    ukwial = load_vehicle("ukwial")
    null = np.sign(np.linalg.svd(ukwial.T)[2][-1])
    near, far = 10 * null, 20 * null  # every thrust along the null space, and T* tau has no part in it
    forced = replace(ukwial, f_min=np.minimum(near, far), f_max=np.maximum(near, far))
    assert closed_form_volume(forced) == 0
    assert attainable_volume(forced) == pytest.approx(attainable_volume(ukwial) * (10 / 500) ** 3)


def test_a_weakened_thruster_leaves_a_volume_between_that_of_one_off_and_one_ready() -> None:
    heavy = load_vehicle("bluerov2-heavy")
    weak = heavy.with_fault(2, 0.5)
    assert attainable_volume(heavy.with_fault(2)) < attainable_volume(weak) < attainable_volume(heavy)


@pytest.mark.parametrize("name", list_vehicles())
@pytest.mark.parametrize("mirrored", [False, True])
def test_limits_never_act_below_the_safe_share_and_do_just_above_it(name: str, mirrored: bool) -> None:
    vehicle = load_vehicle(name)
    if mirrored:  # so that the upper limits decide for some vehicles, the lower ones for others
        vehicle = replace(vehicle, f_min=-vehicle.f_max, f_max=-vehicle.f_min)
    share = safe_share(vehicle)
    inside = uniform_demands(vehicle, np.random.default_rng(3), 5000)
    edge = inside * alpha_max(vehicle, inside)[:, None]
    assert served(vehicle, share * (1 - 1e-9) * edge).all()
    # Each corner of the set asks the most of one thruster on one side: the argument of the support.
    M = generalized_inverse(vehicle) @ vehicle.TP
    signs = np.vstack([M, -M])
    corners = np.where(signs > 0, vehicle.f_max, vehicle.f_min) @ vehicle.TP.T
    above = served(vehicle, share * (1 + 1e-6) * corners)
    assert not above.all() or share == 1


def test_at_nullity_zero_the_safe_share_is_one() -> None:
    assert safe_share(load_vehicle("ukwial").with_fault(0)) == pytest.approx(1)


def test_where_zero_thrust_is_forbidden_the_safe_share_is_zero() -> None:
    forced = replace(load_vehicle("ukwial"), f_min=[10.0, -250, -250, -250])
    assert safe_share(forced) == 0


def test_the_worst_fault_leaves_the_least_volume() -> None:
    supply = load_vehicle("supply-vessel")
    left = [attainable_volume(supply.with_fault(i)) for i in range(supply.n)]
    assert worst_fault(supply) == int(np.argmin(left))


def test_lost_rank_is_worse_than_any_lost_volume_unless_rank_is_to_be_kept() -> None:
    six = load_vehicle("bluerov2")  # its two vertical thrusters are all it has for heave and roll
    ranks = [six.with_fault(i).rank for i in range(six.n)]
    assert ranks[worst_fault(six)] == 4
    assert ranks[worst_fault(six, keep_rank=True)] == 5


def test_too_many_thrusters_for_exact_volumes_are_refused() -> None:
    many = Vehicle(
        name="many",
        dof=("surge", "sway", "heave", "roll", "pitch", "yaw"),
        T=np.random.default_rng(1).normal(size=(6, 30)),
        H=np.eye(30),
        f_min=-np.ones(30),
        f_max=np.ones(30),
        readiness=np.ones(30),
        slack_weights=np.ones(6),
    )
    with pytest.raises(NotApplicable, match="593775 tiles"):
        attainable_volume(many)
