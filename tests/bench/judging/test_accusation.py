"""Time until a monitor accuses: as told by its equations, by noise that is drawn, and by simulated dives."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.allocation import FloatArray
from alloc.c import accusations
from alloc.c.suspicion import ACCUSED, LASTING
from alloc.lint.isolation import assumed_noise
from bench.demands.mission import M
from bench.judging.accusation import (
    RATE_HZ,
    accused_shares,
    as_text,
    random_waves,
    seconds_to_accuse,
    times_of_thrusters,
    wandering_demands,
)
from dives import CURRENT, GAIN, LASTING_S, body, fly, monitor_accusations, noise_of
from dives import RATE_HZ as ROWS_HZ


def lasting_noise(rng: np.random.Generator, shape: tuple[int, ...], lasting: float) -> FloatArray:
    """Noise (N, ...) of unit variance of which exp(-1 / lasting) is left after each call."""
    rho, noise = np.exp(-1 / lasting), rng.normal(size=shape)
    for row in range(1, len(noise)):
        noise[row] = rho * noise[row - 1] + np.sqrt(1 - rho**2) * noise[row]
    return noise


@pytest.mark.parametrize(("thruster", "size"), [(0, 0.15), (3, 0.25)])
def test_the_share_that_is_accused_is_that_of_noise_that_is_drawn(thruster: int, size: float) -> None:
    vehicle, rng = load_vehicle("ukwial"), np.random.default_rng(5)
    t = np.arange(400) / RATE_HZ
    F = np.swapaxes(
        wandering_demands(vehicle, random_waves(rng, 300, vehicle.k), t) @ np.linalg.pinv(vehicle.T).T, 0, 1
    )
    noise = size * assumed_noise(vehicle)
    shares = accused_shares(vehicle, noise, F)[:, thruster]
    drawn = noise * lasting_noise(rng, (len(t), len(F), vehicle.k), LASTING)
    made = F * np.where(np.arange(vehicle.n) == thruster, 0.0, 1.0)
    counted = np.zeros(len(t))
    for i, f in enumerate(F):
        _, who, odds = accusations(vehicle, noise, f, made[i] @ vehicle.T.T + drawn[:, i])
        counted += (who == thruster) & (odds > ACCUSED)
    middle = int(np.argmax(shares >= 0.5))
    assert 0.3 < shares[middle] < 0.7
    for call in (middle, len(t) - 1):
        assert counted[call] / len(F) == pytest.approx(shares[call], abs=0.08)  # 300 cases: 2.8 deviations


def test_a_thruster_that_is_told_soon_is_accused_in_that_time_on_simulated_dives() -> None:
    plain, dives, dead = load_vehicle("bluerov2-heavy"), 60, 5
    size, rng = body(plain), np.random.default_rng(7)
    vehicle = replace(plain, inertia=size * M)
    healthy = fly(vehicle, rng, np.ones((dives, vehicle.n)), current=CURRENT, size=size, gain=GAIN)
    noise = noise_of(vehicle, healthy, size)
    shares = accused_shares(vehicle, noise, healthy.f, LASTING_S * ROWS_HZ)
    told = float(seconds_to_accuse(shares, ROWS_HZ)[dead])
    readiness = np.where(np.arange(vehicle.n) == dead, 0.0, np.ones((dives, vehicle.n)))
    flight = fly(vehicle, rng, readiness, current=CURRENT, size=size, gain=GAIN)

    def named(seconds: float) -> float:
        found = monitor_accusations(vehicle, noise, flight, size, seconds)
        return float(np.mean([accused == {dead} for _, accused in found]))

    assert named(told) >= 0.95
    assert named(told / 3) < 0.95  # told is no safe guess far above


def test_more_noise_takes_longer_and_outer_thrusters_that_look_alike_are_never_told() -> None:
    vehicle = load_vehicle("ukwial")
    noise = 0.2 * assumed_noise(vehicle)
    assert (times_of_thrusters(vehicle, 1.5 * noise) > 1.3 * times_of_thrusters(vehicle, noise)).all()
    vessel = load_vehicle("supply-vessel")
    times = times_of_thrusters(vessel, 0.1 * assumed_noise(vessel))
    assert np.isinf(times[[0, 3]]).all()  # 0 and 1, and 2 and 3, push nearly alike
    assert (times[4:] < 10.0).all()
    text = as_text(vessel, times, "as flown")
    assert "told     thruster 3: not surely accused" in text
    assert "soon     4 of 6 thrusters within 10 s" in text


def test_of_demands_that_are_stated_those_that_ask_more_tell_sooner() -> None:
    vehicle, rng = load_vehicle("ukwial"), np.random.default_rng(2)
    taus = wandering_demands(vehicle, random_waves(rng, 1, vehicle.k), np.arange(1000) / RATE_HZ)[:, 0]
    noise = 0.1 * assumed_noise(vehicle)
    times = times_of_thrusters(vehicle, noise, taus)
    assert (times_of_thrusters(vehicle, noise, 0.6 * taus) > times).all()
    assert times_of_thrusters(vehicle, noise, taus, 2 * RATE_HZ) == pytest.approx(times / 2)
