"""``thrustbench check --failures``: which failures show, and a CSV of demands that another command flies."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import load_vehicle
from alloc.lint.isolation import isolation
from bench.__main__ import cli
from bench.inputs.demand_csv import read_demands

WAVES = "\n".join(
    ["t,surge,sway,yaw"]
    + [
        f"{0.1 * i:.1f},{90 * np.sin(i / 5):.3f},{40 * np.cos(i / 3):.3f},{30 * np.sin(i):.3f}"
        for i in range(300)
    ]
)
"""A log of half a minute that asks something of each axis of ukwial."""


def check(*options: str) -> str:
    return both(*options)[0]


def both(*options: str) -> tuple[str, str]:
    """Run the command, and return its standard output and error."""
    done = CliRunner().invoke(cli, ["check", "ukwial", "--no-picture", "--failures", *options])
    assert done.exit_code == 0, done.output
    return done.stdout, done.stderr


def with_columns(**columns: str) -> str:
    """The log with more columns, each of one value."""
    header, *rows = WAVES.splitlines()
    return "\n".join([",".join([header, *columns]), *(",".join([row, *columns.values()]) for row in rows)])


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
    flown.write_text(WAVES)
    assert f"at 10 calls a second and the demands of {flown}" in check("--demands", str(flown))
    flown.write_text(flown.read_text().replace("sway", "sideways"))
    assert f"and the demands of {flown}" in check("--demands", str(flown), "--columns", "sway=sideways [N]")


def test_a_thruster_that_its_rows_limits_keep_from_pushing_is_not_accused(tmp_path: Path) -> None:
    flown, noise = tmp_path / "flown.csv", ("--noise", "2,2,0.5")
    flown.write_text(WAVES)
    assert "told     thruster 0: if it is off, accused after" in check("--demands", str(flown), *noise)
    flown.write_text(with_columns(f0_min="-0.5", f0_max="0.5"))
    assert "told     thruster 0: not surely accused" in check("--demands", str(flown), *noise)


def test_a_log_that_is_short_or_without_times_is_said_to_be_and_remarks_on_it_are_printed(
    tmp_path: Path,
) -> None:
    flown = tmp_path / "flown.csv"
    flown.write_text("\n".join(WAVES.splitlines()[:7]))
    text, remarks = both("--demands", str(flown))
    assert "told     thruster 0: not surely accused in 0.6 s" in text
    assert f"at 10 calls a second and the demands of {flown}, which last 0.6 s;" in text
    assert remarks.startswith("flown.csv: frame frd (the file names none)")
    flown.write_text("\n".join(line.partition(",")[2] for line in WAVES.splitlines()))
    assert f"at 50 calls a second (assumed) and the demands of {flown}, which last 6 s;" in check(
        "--demands", str(flown)
    )
    flown.write_text("\n".join(["t,surge,sway,yaw", *["0,9,2,3"] * 9]))
    text, remarks = both("--demands", str(flown))
    assert "at 50 calls a second (assumed)" in text
    assert "\nwarning: flown.csv: most rows have the previous row's time, so no rate is known" in remarks
