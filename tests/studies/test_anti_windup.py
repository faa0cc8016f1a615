"""Rules against windup: what the integral of a simulated loop does, whole, saturated and after failures."""

import numpy as np
import pytest

from anti_windup import SHARE, STEP, WRENCH, fly
from tests.conftest import shipped

HEAVE = {"heave": 1.0}


@pytest.mark.parametrize(
    ("off", "step", "most"), [((), STEP, 3.2), ((0,), HEAVE, 0.3), ((4,), HEAVE, 0.3), ((4, 5), HEAVE, 0.1)]
)
def test_an_integral_that_holds_where_the_wrench_differs_does_not_wind_up(
    off: tuple[int, ...], step: dict[str, float], most: float
) -> None:
    """It ends at nothing, and its largest value is that of a step that meets no limit."""
    vehicle = shipped("bluerov2-heavy")
    for thruster in off:
        vehicle = vehicle.with_fault(thruster)
    integrals = fly(WRENCH, vehicle, step)[1]
    assert np.abs(integrals).max() < most
    assert np.abs(integrals[-1]).max() < 0.01


def test_a_share_of_one_does_not_say_that_nothing_is_missing() -> None:
    """Two verticals of one side off: heave and roll go together, and each share is 1."""
    vehicle = shipped("bluerov2-heavy").with_fault(4).with_fault(5)
    assert np.abs(fly(SHARE, vehicle, HEAVE)[1][-1]).max() > 30
