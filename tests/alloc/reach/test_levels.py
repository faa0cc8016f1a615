"""Whose a direction is where one is lost: what a level's step may move beside its own axes."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pytest

from alloc import Status, Vehicle, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.c import missing
from alloc.errors import VehicleError
from alloc.reach.way import OWN, Levels, groups, step_maps
from tests.coupled import coupled

ROUNDING = 1e-12


def without(vehicle: Vehicle, thrusters: tuple[int, ...]) -> Vehicle | None:
    """The vehicle with these thrusters off, None where that leaves nothing."""
    try:
        for i in thrusters:
            vehicle = vehicle.with_fault(i)
    except VehicleError:
        return None
    return vehicle


def lost() -> Iterator[tuple[Vehicle, Levels]]:
    """Each shipped vehicle with two thrusters off or one where a direction is lost, and coupled ones."""
    for name in list_vehicles():
        whole = load_vehicle(name)
        for off in [*combinations(range(whole.n), 1), *combinations(range(whole.n), 2)]:
            vehicle = without(whole, off)
            if vehicle is not None and vehicle.rank < vehicle.k:
                yield from ((vehicle, levels) for levels in ordered(vehicle))
    rng = np.random.default_rng(2004)
    for _ in range(200):
        vehicle = coupled(rng)
        yield from ((vehicle, levels) for levels in ordered(vehicle))


def ordered(vehicle: Vehicle) -> Iterator[Levels]:
    """The levels of priority and of groups, and an axis a level."""
    yield vehicle.priority
    yield vehicle.groups or groups(vehicle, vehicle.T)
    yield [[axis] for axis in vehicle.dof]


def steps(vehicle: Vehicle, levels: Levels) -> list[FloatArray]:
    """The maps of the steps, both sides in unit of ``row_lengths``."""
    unit = vehicle.row_lengths
    return [D * unit / unit[:, None] for D in step_maps(vehicle, levels)]


def test_a_step_moves_other_axes_little_farther_than_its_own_and_those_of_earlier_levels_less(
    rng: np.random.Generator,
) -> None:
    for vehicle, levels in lost():
        before: list[int] = []
        for level, D in zip(levels, steps(vehicle, levels), strict=True):
            rows = [vehicle.dof.index(axis) for axis in level]
            moved = D @ rng.normal(size=(vehicle.k, 20))
            own, whole = np.linalg.norm(moved[rows], axis=0), np.linalg.norm(moved, axis=0)
            assert (own >= OWN * whole - ROUNDING).all(), vehicle.name
            for earlier in before:
                assert (np.abs(moved[earlier]) <= OWN * whole + ROUNDING).all(), vehicle.name
            before += rows


def test_a_later_level_takes_nothing_back() -> None:
    for vehicle, levels in lost():
        maps = steps(vehicle, levels)
        for i, D in enumerate(maps):
            for later in maps[i + 1 :]:
                np.testing.assert_allclose(D @ later, 0.0, atol=ROUNDING, err_msg=vehicle.name)


def test_all_levels_together_reach_what_thrusters_push_and_nothing_else() -> None:
    for vehicle, levels in lost():
        left = np.eye(vehicle.k)
        for D in steps(vehicle, levels):
            left = left - D @ left
        U = np.linalg.svd(vehicle.TP / vehicle.row_lengths[:, None])[0]
        pushed, unpushed = U[:, : vehicle.rank], U[:, vehicle.rank :]
        np.testing.assert_allclose(left @ pushed, 0.0, atol=ROUNDING, err_msg=vehicle.name)
        np.testing.assert_allclose(unpushed.T @ left, unpushed.T, atol=ROUNDING, err_msg=vehicle.name)


@pytest.mark.parametrize("made", ["", "@native"])
@pytest.mark.parametrize("rule", ["priority", "scaled-by-group"])
def test_an_axis_alone_is_served_but_for_what_no_thruster_pushes(
    rule: str, made: str, rng: np.random.Generator
) -> None:
    """Small demands: that is how far the wrench lies from one, and PARTIAL says so."""
    if made and (why := missing()):
        pytest.skip(why)
    for _ in range(5 if made else 50):
        vehicle = coupled(rng)
        allocate, unit = build(rule + made, vehicle), vehicle.row_lengths
        unpushed = np.linalg.norm(np.linalg.svd(vehicle.TP / unit[:, None])[0][:, vehicle.rank :], axis=1)
        for axis, left_out in zip(np.eye(vehicle.k), unpushed.tolist(), strict=True):
            found = allocate(axis * unit)
            missed = np.linalg.norm((vehicle.TP @ found.f) / unit - axis)
            assert missed <= left_out / OWN + 1e-9
            assert set(found.share) == {1.0}
            assert found.status is (Status.PARTIAL if left_out > 1e-8 else Status.SOLVED)
