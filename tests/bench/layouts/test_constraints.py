"""Mounting box, distance and wakes, on thrusters placed by hand."""

import numpy as np
import pytest

from bench.layouts.measure import refused
from bench.layouts.space import PlacedThrusters
from bench.layouts.study import Constraints, MountingBox, Wake


def two(second: list[float], f_min: float = -10.0) -> PlacedThrusters:
    """A thruster at the origin that pushes ahead, and another one to port of it, or where it is said."""
    return PlacedThrusters(
        which=np.arange(1),
        position=np.array([[0.0, 0.0, 0.0], second])[..., None],
        direction=np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])[..., None],
        center=np.zeros((3, 1)),
        f_min=np.full((2, 1), f_min),
        f_max=np.full((2, 1), 10.0),
        weights=np.ones((2, 1)),
    )


def broken(poses: PlacedThrusters, constraints: Constraints) -> list[str]:
    """The constraints that the only layout breaks."""
    return [reason for reason, which in refused(poses, constraints).items() if which.all()]


def test_a_thruster_outside_of_the_box_is_refused_and_on_its_edge_is_not() -> None:
    box = Constraints(box=MountingBox(x=(0.0, 1.0), z=(-1.0, 1.0)))
    assert broken(two([1.0, 5.0, 0.0]), box) == []
    assert broken(two([1.01, 5.0, 0.0]), box) == ["box.x"]
    assert broken(two([1.0, 5.0, -1.01]), box) == ["box.z"]


def test_thrusters_nearer_than_the_distance_are_refused() -> None:
    near = Constraints(distance=0.5)
    assert broken(two([0.3, 0.4, 0.0]), near) == []
    assert broken(two([0.3, 0.39, 0.0]), near) == ["distance"]


@pytest.mark.parametrize(
    ("second", "f_min", "hit"),
    [
        ([-0.5, 0.05, 0.0], -10.0, True),  # astern: where water goes that is pushed to go ahead
        ([-0.5, 0.15, 0.0], -10.0, False),  # beside the jet
        ([-1.5, 0.05, 0.0], -10.0, False),  # beyond its reach
        ([0.5, 0.05, 0.0], -10.0, True),  # ahead, when it reverses
        ([0.5, 0.05, 0.0], 0.0, False),  # ahead of a thruster that can't
    ],
)
def test_a_thruster_in_a_jet_is_refused(second: list[float], f_min: float, hit: bool) -> None:
    jet = Constraints(wake=Wake(length=1.0, radius=0.1))
    assert (broken(two(second, f_min), jet) == ["wake"]) is hit


def test_a_jet_widens_by_its_spread() -> None:
    aside = two([-0.5, 0.15, 0.0])
    assert broken(aside, Constraints(wake=Wake(length=1.0, radius=0.1, spread_deg=10.0))) == ["wake"]
