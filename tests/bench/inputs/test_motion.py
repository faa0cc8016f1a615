"""Motion of a dive from an autopilot's sensors, in both kinds of its logs."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.errors import DemandError
from alloc.vehicle.frame import turned
from bench.inputs.outputs import Motion, Sensors, estimate_motion, read_motion, read_outputs
from tests.dives import Dive, SensorLog, dive, simulate_sensors
from tests.output_logs import write_bin, write_outputs_ulog

Write = Callable[[Path, Vehicle, Dive, SensorLog | None], Path]


def as_bin(path: Path, vehicle: Vehicle, flown: Dive, seen: SensorLog | None) -> Path:
    u = np.rint(vehicle.commands(flown.f).u).astype(int)
    return write_bin(path, flown.t, u, np.full(len(u), 16.0), np.zeros((len(u), 3)), sensors=seen)


def as_ulog(path: Path, vehicle: Vehicle, flown: Dive, seen: SensorLog | None) -> Path:
    u = vehicle.commands(flown.f).u
    return write_outputs_ulog(path, flown.t, u, np.full(len(u), 16.0), np.zeros((len(u), 6)), sensors=seen)


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle("bluerov2-heavy")


@pytest.fixture(scope="module")
def flown(vehicle: Vehicle) -> Dive:
    """A dive whose sensors are without noise."""
    return dive(vehicle, np.random.default_rng(7), np.ones(vehicle.n), noise=0.0)


def assert_flown(motion: Motion, flown: Dive) -> None:
    """Compare with what the velocities of the dive became from row to row."""
    assert motion.rows.sum() > 0.95 * len(flown.t)
    v = ((flown.v[1:] + flown.v[:-1]) / 2)[motion.rows[:-1]]
    a = (np.diff(flown.v, axis=0) / np.diff(flown.t)[:, None])[motion.rows[:-1]]
    assert np.abs(motion.v - v).max() <= 0.02 * np.abs(v).max()
    size = np.sqrt((a**2).mean(axis=0))
    assert (np.sqrt(((motion.a - a) ** 2).mean(axis=0)) <= 0.05 * size).all()


@pytest.mark.parametrize("write", [as_bin, as_ulog])
def test_the_motion_is_that_of_the_dive(tmp_path: Path, vehicle: Vehicle, flown: Dive, write: Write) -> None:
    log = write(tmp_path, vehicle, flown, simulate_sensors(flown, vehicle.dof))
    assert_flown(read_motion(log, read_outputs(log, vehicle, sensed=True), vehicle), flown)


@pytest.mark.parametrize(("write", "lacks"), [(as_bin, "holds no IMU"), (as_ulog, "holds no vehicle_acc")])
def test_a_log_without_sensors_is_refused(
    tmp_path: Path, vehicle: Vehicle, flown: Dive, write: Write, lacks: str
) -> None:
    log = write(tmp_path, vehicle, flown, None)
    with pytest.raises(DemandError, match=lacks):
        read_motion(log, read_outputs(log, vehicle, sensed=True), vehicle)


def series(seen: SensorLog) -> Sensors:
    return Sensors(
        (seen.t, seen.force), (seen.t, seen.rates), (seen.t, seen.attitude), (seen.t, seen.velocity), "x"
    )


def test_a_vehicle_with_z_up_gets_the_motion_in_its_frame(vehicle: Vehicle, flown: Dive) -> None:
    seen = series(simulate_sensors(flown, vehicle.dof))
    frd = estimate_motion(Path("x"), seen, flown.t, vehicle)
    flu = estimate_motion(Path("x"), seen, flown.t, vehicle.with_frame("flu"))
    np.testing.assert_allclose(turned(flu.a.T, vehicle.dof).T, frd.a, atol=1e-12)
    np.testing.assert_allclose(turned(flu.v.T, vehicle.dof).T, frd.v, atol=1e-12)


def test_nothing_is_interpolated_over_a_gap(vehicle: Vehicle, flown: Dive) -> None:
    seen = simulate_sensors(flown, vehicle.dof)
    kept = (seen.t < 5.0) | (seen.t > 9.0)
    motion = estimate_motion(Path("x"), series(SensorLog(*(each[kept] for each in seen))), flown.t, vehicle)
    assert not motion.rows[(flown.t > 5.1) & (flown.t < 8.9)].any()
    assert motion.rows[(flown.t > 0.1) & (flown.t < 4.9)].all()


def test_sensors_of_another_time_are_refused(vehicle: Vehicle, flown: Dive) -> None:
    with pytest.raises(DemandError, match="other times"):
        estimate_motion(Path("x"), series(simulate_sensors(flown, vehicle.dof)), flown.t + 100.0, vehicle)
