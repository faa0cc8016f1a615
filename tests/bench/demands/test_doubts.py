"""Units of a log that can't be right are said, with the factor that would mend them."""

import numpy as np
import pytest

from alloc import alpha_max, load_vehicle
from bench.demands.doubts import doubts

UKWIAL = load_vehicle("ukwial")
WAYS = np.array([[1.0, 0.2, 0.0], [-0.5, 1.0, 0.1], [0.3, -0.4, 0.2]])
SOUND = 0.7 * alpha_max(UKWIAL, WAYS)[:, None] * WAYS
"""Demands at 70 % of what the vehicle can do."""


def lines(taus: np.ndarray, rate_hz: float | None) -> list[str]:
    return doubts("log", UKWIAL.name, alpha_max(UKWIAL, taus), rate_hz)


def test_a_sound_log_raises_no_doubt() -> None:
    for factor in (0.01, 1.0, 100.0):
        assert lines(factor * SOUND, 50.0) == []
    assert lines(SOUND, None) == []


def test_of_shares_no_unit_is_in_doubt() -> None:
    """A PX4 log of a strong vehicle was told of kN."""
    assert doubts("log", UKWIAL.name, alpha_max(UKWIAL, 0.001 * SOUND), 50.0, shares=True) == []


@pytest.mark.parametrize(
    ("factor", "rate", "says"),
    [
        (1000.0, 50.0, "asks 700 times what ukwial can do; if it is in mN, --scale 0.001"),
        (0.001, 50.0, "never asks more than 0.0007 of what ukwial can do; if it is in kN, --scale 1000"),
        (1.0, 0.05, "0.05 Hz; were its times in ms, 50 Hz: name the column 't [ms]'"),
        (1.0, 5e-5, "were its times in us, 50 Hz"),
        (1.0, 5e-8, "were its times in ns, 50 Hz"),
        (1.0, 1e6, "1e+06 Hz is no rate of a control loop"),
    ],
)
def test_a_wrong_unit_is_said_with_its_factor(factor: float, rate: float, says: str) -> None:
    (line,) = lines(factor * SOUND, rate)
    assert says in line
