"""``thrustbench check --failures``: which failures show, and a CSV of demands that another command flies."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import load_vehicle
from alloc.lint.isolation import isolation
from bench.__main__ import cli
from bench.inputs.demand_csv import read_demands


def check(*options: str) -> str:
    done = CliRunner().invoke(cli, ["check", "ukwial", "--no-picture", "--failures", *options])
    assert done.exit_code == 0, done.output
    return done.stdout


def test_the_demands_to_fly_are_a_csv_that_is_read_as_demands(tmp_path: Path) -> None:
    out = tmp_path / "fly.csv"
    text = check("-o", str(out))
    vehicle = load_vehicle("ukwial")
    assert read_demands(out, vehicle.dof).taus == pytest.approx(
        isolation(vehicle).trials[0].tau[None], abs=1e-6
    )
    assert "assumed: 5 %" in text
    assert "tells any two others apart, if one is off" in text


def test_noise_is_one_number_or_one_for_each_axis() -> None:
    text = check("--noise", "4,4,2")
    assert "noise    surge 4 N, sway 4 N, yaw 2 N m (one standard deviation)" in text


def test_each_thruster_has_a_time_and_demands_that_are_stated_are_asked(tmp_path: Path) -> None:
    text = check("--noise", "8,8,2")
    assert "told     thruster 3: if it is off, accused after " in text
    assert "thrusters within 10 s, in 95 % of cases, by codegen --monitor, at 50 calls a second" in text
    flown = tmp_path / "flown.csv"
    rows = [
        f"{0.1 * i:.1f},{90 * np.sin(i / 5):.3f},{40 * np.cos(i / 3):.3f},{30 * np.sin(i):.3f}"
        for i in range(300)
    ]
    flown.write_text("\n".join(["t,surge,sway,yaw", *rows]))
    assert f"at 10 calls a second and the demands of {flown}" in check("--demands", str(flown))
    flown.write_text(flown.read_text().replace("sway", "sideways"))
    assert f"and the demands of {flown}" in check("--demands", str(flown), "--columns", "sway=sideways [N]")
