"""report.md answers two questions of a pilot: what is weak on my vehicle, what do I lose by which method.

The answers that are judged are real, times are made up: methods that lose more are faster, as they are.
"""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest

from alloc import build, load_vehicle
from bench.demands import build_demands
from bench.harness.lines import problem
from bench.judging.capability import measure_capabilities
from bench.judging.judge import judge
from bench.judging.question import ask_here, questions
from bench.record import Cell, Key, Line, Problem
from bench.report.page import page
from bench.results.rows import Run
from tests import made_up

METHODS = {"clip": 1, "pinv": 1, "nullspace": 2, "scaled": 20}
"""Median of a call by method [us]."""
SETS = ("inactive", "infeasible", "mission")


@cache
def lines(name: str) -> tuple[Line, ...]:
    vehicle = load_vehicle(Path(name) if "/" in name else name)
    made: list[Line] = []
    for question in questions([build_demands(each, vehicle, 0, 50) for each in SETS], ask_here):
        made.append(problem(question))
        for method, us in METHODS.items():
            allocate = build(method, vehicle)
            given = [allocate(tau) for tau in question.demands.taus]
            judged = judge(
                question,
                given,
                formulation=allocate.formulation,
                limited=allocate.limited,
                tolerance=allocate.tolerance,
            )
            made.append(
                cell(Key(vehicle.name, question.demands.name, method), us, judged, allocate.formulation)
            )
    return (*made, *measure_capabilities([vehicle], list(METHODS), 0, ask_here, 100))


def cell(key: Key, us: int, judged: object, formulation: str) -> Cell:
    return msgspec.structs.replace(
        made_up.cell(key.method, us),
        key=key,
        judged=judged,
        formulation=formulation,
        limited=True,
        n_demands=50,
    )


@pytest.fixture
def surveyed(tmp_path: Path) -> Run:
    return made_up.run(tmp_path, *lines("docs/vehicles/bluerov2-surveyed.yaml"))


def test_the_headline_takes_what_loses_nothing_and_names_what_the_others_would_do(surveyed: Run) -> None:
    text = page(surveyed, frozenset())
    first, second, *flat = [line for line in text.splitlines() if line.startswith("- bluerov2-surveyed")]
    assert all("shares of a set of" in line for line in flat)
    assert "take scaled" in first
    assert "exact" in first
    assert "weak: pitch (0.5 % left)" in second
    assert re.search(r"scaled 6\d\.\d N, thrusts up to 22\.5 N", second)
    assert "nullspace refused; at most 12 N, thrusts up to 40 N" in second
    assert "clip 0 N, thrusts up to 40 N" in second


def test_the_page_says_what_is_weak_and_what_each_method_makes_along_each_axis(surveyed: Run) -> None:
    text = page(surveyed, frozenset())
    assert "## What is weak, and who loses by it" in text
    assert "### bluerov2-surveyed, weak: pitch (0.5 % left)" in text
    table = [line for line in text.splitlines() if line.startswith(("| surge ", "| heave ", "| yaw "))]
    assert len(table) == 3
    assert "weak: pitch (0.5 % left); labels and losses are of all that counts." in text


def test_what_counts_in_part_is_said_in_the_same_words_with_how_much(tmp_path: Path) -> None:
    vehicle = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
    found = vehicle.directions
    half = float(found.sigma[-1] / found.sigma[0]) / 1.5
    own = problem(*questions([build_demands("axes", replace(vehicle, weak_limit=half), 0, 50)], ask_here))
    told = {"weak": own.weak, "weak_bound_N": own.weak_bound_N}
    text = page(
        made_up.run(
            tmp_path,
            *(
                msgspec.structs.replace(each, **told) if isinstance(each, Problem) else each
                for each in lines("docs/vehicles/bluerov2-surveyed.yaml")
            ),
        ),
        frozenset(),
    )
    words = "weak: pitch (0.5 % left, counts by 50 %)"
    assert f"- bluerov2-surveyed: {words}" in text
    assert f"### bluerov2-surveyed, {words}" in text


def test_rows_state_the_weak_axis_its_bound_and_alpha_of_the_hard_problem(surveyed: Run) -> None:
    table = surveyed.table
    assert set(table.weak) == {"pitch (0.5 % left)"}
    assert table.weak_bound_N.unique() == pytest.approx(1.2, abs=0.01)
    inactive = table[table.demands == "inactive"]
    assert (inactive.alpha_hard < 1.0).all()  # half of the easy demands and more are beyond eq. 4-5
    by_method = inactive.set_index("method")
    assert by_method.loc["scaled", "within_1pct_share"] == 1.0
    assert by_method.loc["nullspace", "answered_share"] < 0.7


def test_a_vehicle_without_weak_axes_has_no_word_of_them(tmp_path: Path) -> None:
    run = made_up.run(tmp_path, *lines("bluerov2"))
    assert "weak" not in page(run, frozenset()).lower()
    assert set(run.table.weak) == {""}
    assert np.isnan(run.table.alpha_hard).all()
    assert np.isnan(run.table.weak_bound_N).all()
