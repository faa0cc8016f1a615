"""The study of weak axes: programs that tell what a survey allows a first level, found by HiGHS."""

from dataclasses import replace

import numpy as np
import pytest

from alloc.vehicle.weak import DRAWN
from bench.demands.surveys import fail_thrusters, move_poses, pushable_demands
from tests.conftest import shipped
from weak_axes import delivered, programs


def test_a_first_level_gets_what_a_program_of_its_own_step_gives_and_others_could_give_more() -> None:
    """Without a horizontal and a vertical thruster the level's roll takes other axes along."""
    levels = (("heave", "roll"), ("surge", "sway", "yaw"))
    drawing = replace(shipped("bluerov2"), priority=levels)
    rng = np.random.default_rng(3)
    found = fail_thrusters(move_poses(drawing, DRAWN, rng), (0, 4))
    taus = pushable_demands(found, 12, rng)
    made = delivered("priority", found, taus)
    own, free = np.array([programs("priority", found, tau) for tau in taus]).T
    assert own == pytest.approx(made, abs=1e-6)
    assert (free >= made - 1e-6).all()
    assert 0.0 < made.min() < 0.95
    assert (free[made < 0.95] > 1.02 * made[made < 0.95]).any()
