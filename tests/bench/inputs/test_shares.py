"""Demands in shares of what a vehicle can do are doubted: as newtons they are tiny, and all methods serve."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from alloc import load_vehicle
from bench.__main__ import cli
from bench.demands import build_demands
from bench.inputs.csv_text import csv_text
from bench.inputs.logs import LogOptions, log_for

HEAVY = load_vehicle("bluerov2-heavy")
T = np.arange(60) / 50
STICKS = np.sin(T[:, None] * np.arange(1, 7)).clip(-0.9, 0.9)


def written(
    folder: Path, taus: np.ndarray, header: tuple[str, ...] = HEAVY.dof, name: str = "sticks"
) -> Path:
    file = folder / f"{name}.csv"
    file.write_text(csv_text(["t", *header], np.column_stack([T, taus]).tolist()))
    return file


def thrustbench(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [*map(str, arguments)], standalone_mode=False)


@pytest.mark.parametrize(("factor", "doubted"), [(1.0, True), (0.01, True), (5.0, False), (100.0, False)])
def test_a_log_within_1_on_every_axis_is_doubted_until_a_scale_is_given(
    tmp_path: Path, factor: float, doubted: bool
) -> None:
    file = written(tmp_path, factor * STICKS)
    assert ("if these are shares, --scale with what 1 is" in log_for(HEAVY, file).doubt) == doubted
    assert log_for(HEAVY, file, LogOptions(scale=(1.0,))).doubt == ""
    lines = build_demands(file, HEAVY, seed=0).said
    assert any("far below what bluerov2-heavy can do" in line for line in lines) == doubted


@pytest.mark.parametrize("vehicle", ["bluerov2", "nautilus", "subjugator8", "supply-vessel", "ukwial"])
def test_every_vehicle_that_moves_more_than_ten_newtons_doubts_shares(tmp_path: Path, vehicle: str) -> None:
    answering = load_vehicle(vehicle)
    file = written(tmp_path, STICKS[:, : answering.k], answering.dof)
    assert "if these are shares" in log_for(answering, file).doubt


def test_a_vehicle_of_a_newton_is_asked_for_newtons(tmp_path: Path) -> None:
    tiburon = load_vehicle("tiburon")
    assert log_for(tiburon, written(tmp_path, STICKS[:, : tiburon.k], tiburon.dof)).doubt == ""


def test_demands_that_are_zero_or_unknown_are_no_shares(tmp_path: Path) -> None:
    assert log_for(HEAVY, written(tmp_path, 0 * STICKS)).doubt == ""


def test_a_scale_counts_beside_commands_too(tmp_path: Path) -> None:
    """It was left aside where a table did not say that it has shares, which no table does."""
    made = np.full((len(T), 8), 1500.0)
    shares = np.column_stack([0.2 * STICKS, made])
    newtons = np.column_stack([0.2 * STICKS * 40, made])
    header = (*HEAVY.dof, *(f"u{i}" for i in range(8)))
    command = ("demands", "--vehicle", "bluerov2-heavy", "--from-outputs")
    scaled = thrustbench(*command, written(tmp_path, shares, header), "--scale", 40)
    alone = thrustbench(*command, written(tmp_path, newtons, header, "newtons"))
    assert (
        scaled.output.partition("undone")[2].splitlines()[0]
        == alone.output.partition("undone")[2].splitlines()[0]
    )
    assert "if these are shares" not in scaled.stderr
    assert "if these are shares" in thrustbench(*command, written(tmp_path, shares, header)).stderr


def test_a_scale_of_no_demands_is_refused(tmp_path: Path) -> None:
    file = written(tmp_path, np.full((len(T), 8), 1500.0), tuple(f"u{i}" for i in range(8)))
    done = thrustbench("demands", file, "--vehicle", "bluerov2-heavy", "--from-outputs", "--scale", 2)
    assert "has no demands that could be scaled; leave out --scale" in str(done.exception)
