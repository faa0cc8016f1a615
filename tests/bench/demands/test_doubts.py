"""Units of a log that can't be right are said, with the factor that would mend them."""

from pathlib import Path

import numpy as np
import pytest

from alloc import alpha_max, load_vehicle
from bench.demands import build_demands
from bench.demands.doubts import doubts
from bench.inputs.columns import parse_columns
from bench.inputs.demand_csv import read_demands

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


@pytest.mark.parametrize(
    ("factor", "rate", "says"),
    [
        (1000.0, 50.0, "asks 700 times what ukwial can do; if the vehicle's limits are in kN"),
        (0.001, 50.0, "never asks more than 0.0007 of what ukwial can do; check the units of its columns"),
        (1.0, 1 / 60, "0.0167 Hz is no rate of a control loop; check the times and their unit"),
    ],
)
def test_no_unit_is_guessed_where_one_is_said(factor: float, rate: float, says: str) -> None:
    """A column 't [min]' was said to be in ms: named so, the log had 1,000 Hz."""
    alpha = alpha_max(UKWIAL, factor * SOUND)
    (line,) = doubts("log", UKWIAL.name, alpha, rate, with_unit={"t", "surge"})
    assert says in line
    assert not {"ms", "mN", "--scale"} & set(line.replace("'", " ").split())


@pytest.mark.parametrize(
    ("header", "columns", "said"),
    [
        ("t [min],surge,sway,yaw", "", {"t"}),
        ("t,surge [N],sway,yaw_Nm", "", {"surge", "yaw"}),
        ("millis,Fx,Fy,Mz", "", {"t"}),
        ("stamp,Fx,Fy,Mz", "t=stamp [s],surge=Fx [N]", {"t", "surge"}),
        ("t,surge,sway,yaw", "", set()),
    ],
)
def test_a_log_tells_of_which_quantities_the_unit_is_said(
    header: str, columns: str, said: set[str], tmp_path: Path
) -> None:
    file = tmp_path / "log.csv"
    file.write_text(f"{header}\n0,1,2,3\n1,1,2,3\n")
    assert read_demands(file, UKWIAL.dof, parse_columns(columns)).with_unit == said


@pytest.mark.parametrize(
    ("header", "guess"), [("t [min],surge [N],sway,yaw", ""), ("t,surge,sway,yaw", "in ms, these are shares")]
)
def test_a_log_with_units_is_told_of_no_others(header: str, guess: str, tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text(f"{header}\n0,0.1,0.2,0.3\n60,0.1,0.2,0.3\n")
    said = "; ".join(build_demands(file, UKWIAL, 0).said)
    assert "no rate" in said or "Hz; were its times" in said
    for words in ("in ms", "these are shares"):
        assert (words in said) == (words in guess)
