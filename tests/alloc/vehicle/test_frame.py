"""One vehicle in two frames: the same demand, turned, gives the same thrusts; what signs mean, in words."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import Vehicle, build, list_vehicles, load_vehicle
from alloc.errors import VehicleError
from alloc.vehicle.frame import AXES, TURN, axis_line, effect, turned
from alloc.vehicle.geometry import DOF, pose_matrix

AHEAD, STARBOARD, DOWN = (np.eye(3)[i] for i in range(3))
"""Directions in the world of a vehicle, in frd."""


def random_vehicle(seed: int, n: int) -> tuple[Vehicle, Vehicle]:
    """A vehicle of n thrusters at random poses in frd; and the same one with every pose written in flu."""
    rng = np.random.default_rng(seed)
    positions, directions = rng.uniform(-1, 1, (n, 3)), rng.standard_normal((n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    high = rng.uniform(20, 60, n)
    same = {
        "name": "made up",
        "dof": DOF,
        "H": np.diag(rng.uniform(0.5, 2, n)),
        "f_min": -0.7 * high,
        "f_max": high,
        "readiness": np.ones(n),
        "slack_weights": np.full(6, 2000.0),
    }
    return (
        Vehicle(T=pose_matrix(positions, directions), **same),  # type: ignore[arg-type]  # as in VehicleFile
        Vehicle(T=pose_matrix(positions * TURN, directions * TURN), frame="flu", **same),  # type: ignore[arg-type]
    )


@given(st.integers(0, 10**6), st.integers(7, 9), st.sampled_from(["pinv", "nullspace", "clip", "scaled"]))
def test_the_same_demand_turned_gives_the_same_thrusts_on_the_same_vehicle_written_in_flu(
    seed: int, n: int, method: str
) -> None:
    frd, flu = random_vehicle(seed, n)
    np.testing.assert_allclose(frd.with_frame("flu").T, flu.T, rtol=0, atol=1e-15)
    rng = np.random.default_rng(seed)
    taus = rng.uniform(-1, 1, (5, 6)) * frd.wrench_scale * rng.choice([0.05, 0.5, 3.0], (5, 1))
    here, status = build(method, frd).many(taus)
    there, said = build(method, flu).many(turned(taus.T, DOF).T)
    np.testing.assert_array_equal(status, said)
    # Rounding differs by what the linear algebra library does with signs; T's condition is below 1e4.
    np.testing.assert_allclose(here, there, rtol=0, atol=1e-8 * frd.f_scale)


@pytest.mark.parametrize("name", list_vehicles())
def test_a_shipped_vehicle_turned_answers_the_turned_demand_alike(name: str) -> None:
    vehicle = load_vehicle(name)
    other = vehicle.with_frame("flu" if vehicle.frame == "frd" else "frd")
    taus = np.vstack([np.eye(vehicle.k), -np.eye(vehicle.k)]) * 0.2 * vehicle.wrench_scale
    here, _ = build("nullspace", vehicle).many(taus)
    there, _ = build("nullspace", other).many(turned(taus.T, vehicle.dof).T)
    np.testing.assert_allclose(here, there, rtol=0, atol=1e-9 * vehicle.f_scale)


@pytest.mark.parametrize("frame", ["frd", "flu"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_words_of_a_force_or_a_turn_are_what_it_does(frame: str, sign: float) -> None:
    """The effect of a unit wrench, worked out in frd: where a force goes, and where a turn takes the bow."""
    ways = {"ahead": AHEAD, "astern": -AHEAD, "starboard": STARBOARD, "port": -STARBOARD}
    ways |= {"down": DOWN, "up": -DOWN}
    for i, axis in enumerate(DOF):
        wrench = sign * np.eye(6)[i]
        force, moment = np.split(wrench if frame == "frd" else turned(wrench, DOF), 2)
        words = effect(axis, frame, sign)
        moved = force if i < 3 else np.cross(moment, STARBOARD if axis == "roll" else AHEAD)
        np.testing.assert_array_equal(moved, ways[words.split()[-1]])
        assert words.startswith(
            "pushes" if i < 3 else "turns the starboard" if axis == "roll" else "turns the bow"
        )


def test_every_axis_has_its_line_in_words() -> None:
    assert axis_line("heave", "frd") == "z down"
    assert axis_line("yaw", "flu") == "z up"
    assert axis_line("pitch", "flu") == "y to port"
    assert set(AXES) == {"frd", "flu"}


def test_a_vehicle_in_no_known_frame_is_refused() -> None:
    vehicle = load_vehicle("ukwial")
    with pytest.raises(VehicleError, match="unknown frame 'ned'; expected frd or flu"):
        Vehicle(
            **{
                key: getattr(vehicle, key)
                for key in ("name", "dof", "T", "H", "f_min", "f_max", "readiness", "slack_weights")
            },
            frame="ned",
        )  # type: ignore[arg-type]
