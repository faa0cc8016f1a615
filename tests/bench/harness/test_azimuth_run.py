"""A run of a ferry whose thrusters turn, end to end: judged by its polygons, and told in words."""

import csv
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from alloc import load_vehicle
from bench.__main__ import cli
from bench.demands.store import pack_vehicle, same_vehicle, unpack_vehicle
from bench.record import read

LINE = (
    "run --vehicle double-ended-ferry --method nullspace --method pinv --method qp/daqp --method soft"
    " --method clip --method redistribute --method priority"
    " --method mine.py --demands active --demands infeasible --demands jolts --n 8 --repeats 1 --budget-ms 1"
    " --level tight --out out"
)
BOXED = """\
import numpy as np

FORMULATION, AZIMUTHS = "scaled-down", True

def build(vehicle):
    G = vehicle.TP.T @ np.linalg.inv(vehicle.TP @ vehicle.TP.T)
    return lambda tau: np.clip(G @ tau, vehicle.f_min, vehicle.f_max)
"""
"""Thrusts within the boxes around the polygons, which some of their corners leave."""


def test_a_run_of_a_ferry_judges_by_polygons_and_goes_on_behind_what_refuses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(BOXED)
    result = CliRunner().invoke(cli, LINE.split(), standalone_mode=False)
    assert result.return_value == 1, result.output
    assert "line 8: thrusters[0].azimuth: demand set 'jolts' takes no azimuth thrusters yet" in " ".join(
        result.output.split()
    )
    cells = {(cell.key.method, cell.key.demands): cell for cell in read(tmp_path / "out").cells}
    for demands in ("active", "infeasible"):
        for method in ("nullspace", "qp/daqp", "clip", "redistribute", "priority"):
            judged = cells[method, demands].judged
            assert judged is not None
            assert judged.wrong == ""
            assert judged.loss["limits_violated_share"] in (0.0, None)
        assert cells["soft", demands].status == "refused"
    judged = cells["mine", "infeasible"].judged
    assert judged is not None
    assert "a limit is violated" in judged.wrong
    rows = list(csv.DictReader((tmp_path / "out" / "results.csv").read_text().splitlines()))
    assert {row["reason"] for row in rows if row["method"] == "soft"} == {
        "soft takes no azimuth thrusters yet: it knows thrusters along a line; see docs/azimuth.md"
    }
    details = (tmp_path / "out" / "details.md").read_text()
    assert "bow, stern" in details
    assert "bow off" in details


def test_a_ferry_with_one_end_off_is_judged_by_what_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    line = "run --vehicle double-ended-ferry --fault bow --method nullspace --method pinv --demands inactive"
    line += " --n 8 --repeats 1 --budget-ms 1 --level tight --out out"
    result = CliRunner().invoke(cli, line.split(), standalone_mode=False)
    assert result.return_value == 0, result.output
    judged = {cell.key.method: cell.judged for cell in read(tmp_path / "out").cells}
    for method in ("nullspace", "pinv"):
        found = judged[method]
        assert found is not None
        assert found.wrong == ""
        assert found.loss["limits_violated_share"] == 0.0


def test_a_worker_gets_the_polygons_of_a_vehicle() -> None:
    ferry = load_vehicle("double-ended-ferry")
    for vehicle in (ferry, ferry.with_fault("bow")):
        there = unpack_vehicle(pack_vehicle(vehicle))
        assert same_vehicle(there, vehicle)
        assert [one.corners.tolist() for one in there.turning] == [
            one.corners.tolist() for one in vehicle.turning
        ]
    corners = [replace(one, corners=0.9 * one.corners) for one in ferry.azimuths]
    assert not same_vehicle(replace(ferry, azimuths=tuple(corners)), ferry)
