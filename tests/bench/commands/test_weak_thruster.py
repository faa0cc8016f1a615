"""``thrustbench demands --accelerations`` on logs of simulated dives, as docs/failures.md shows it."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import load_vehicle
from bench.__main__ import cli
from bench.report.pictures.style import VERMILION
from tests.dives import dive, simulate_sensors, write_dive
from tests.output_logs import write_bin
from tests.pages import blocks
from tests.places import DOCS

(COMMAND,) = (
    line for block in blocks(DOCS / "failures.md", "") for line in block.splitlines() if "motion.csv" in line
)


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A dive with thruster 5 at half strength, in the current folder."""
    monkeypatch.chdir(tmp_path)
    readiness = np.ones(8)
    readiness[5] = 0.5
    vehicle = load_vehicle("bluerov2-heavy")
    flown = dive(vehicle, np.random.default_rng(4), readiness, noise=0.05)
    return write_dive(tmp_path / "motion.csv", vehicle, flown)


def said(command: str) -> str:
    done = CliRunner().invoke(cli, shlex.split(command)[1:])
    assert done.exit_code == 0, done.output
    return done.stdout


def test_the_page_leads_to_the_thruster(log: Path) -> None:
    text = said(COMMAND)
    assert re.search(r"^weak  thruster 5: 0\.[45]\d in 1 of 1 windows$", text, re.MULTILINE)
    assert text.count("weak  ") == 1
    found = re.search(r"thruster 5 (\S+) ± (\S+),", text)
    assert found is not None
    assert abs(float(found[1]) - 0.5) < 0.05


def test_an_autopilots_log_leads_to_the_thruster_with_a_picture(tmp_path: Path) -> None:
    readiness = np.ones(8)
    readiness[5] = 0.5
    vehicle = load_vehicle("bluerov2-heavy")
    flown = dive(vehicle, np.random.default_rng(4), readiness, seconds=41.0, noise=0.02)
    u = np.rint(vehicle.commands(flown.f).u).astype(int)
    still = np.zeros((len(u), 3))
    log = write_bin(
        tmp_path, flown.t, u, np.full(len(u), 16.0), still, sensors=simulate_sensors(flown, vehicle.dof)
    )
    picture = tmp_path / "readiness.svg"
    text = said(f"{COMMAND.replace('motion.csv', str(log))} --picture {picture}")
    assert re.findall(r"^weak  (.*)$", text, re.MULTILINE) == ["thruster 5: 0.50 in 2 of 2 windows"]
    drawn = picture.read_text()
    assert all(
        f">{vehicle.called(i)}<" in drawn or f"<!-- {vehicle.called(i)} -->" in drawn for i in range(8)
    )
    assert drawn.count(VERMILION) >= 2  # both windows of the weak one


def test_without_the_mass_ratios_lead_to_the_thruster(tmp_path: Path) -> None:
    vehicle = load_vehicle("bluerov2")
    assert vehicle.inertia is None
    flown = dive(vehicle, np.random.default_rng(4), np.array([1, 1, 0.5, 1, 1, 1]), noise=0.05)
    log = write_dive(tmp_path / "motion.csv", vehicle, flown)
    text = said(COMMAND.replace("bluerov2-heavy", "bluerov2").replace("motion.csv", str(log)))
    assert "bluerov2 has no 'inertia': mass, drag and readiness could all be scaled together" in text
    assert re.findall(r"^weak  (.*): 0\.[45]\d in 1 of 1 windows$", text, re.MULTILINE) == ["thruster 2"]


def test_a_log_that_lacks_something_is_refused_in_a_line_that_says_what(log: Path) -> None:
    header, *rows = log.read_text().splitlines()
    for missing, says in (
        ("a_yaw", "no column 'a_yaw'; --accelerations needs a_surge"),
        ("t", "no column 't'"),
    ):
        log.write_text("\n".join([header.replace(missing, "other", 1), *rows]))
        done = CliRunner().invoke(cli, shlex.split(COMMAND)[1:])
        assert says in str(done.exception)
        assert "\n" not in str(done.exception)


def test_a_dive_without_motion_says_that_nothing_can_be_said(log: Path) -> None:
    header, *rows = log.read_text().splitlines()
    still = [",".join([row.split(",")[0], *["1500"] * 8, *["0"] * 12]) for row in rows]
    log.write_text("\n".join([header, *still]))
    done = CliRunner().invoke(cli, shlex.split(COMMAND)[1:])
    assert "nothing can be said of any thruster" in str(done.exception)
