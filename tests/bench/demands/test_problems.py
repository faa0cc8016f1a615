"""Published problems: every answer is proven again from its line alone, by the script that the page shows."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from alloc import Vehicle, build, load_vehicle
from alloc.reach.attainable import alpha_max_lp
from bench.demands.problems import (
    ProvenProblem,
    columns,
    for_qpbenchmark,
    problems,
    sequences,
    vehicles,
    write_problems,
)
from tests.pages import blocks
from tests.places import DOCS, ROOT

QUICK = ("active", "boundary", "hard", "inactive", "infeasible", "slew")
INPUTS = ("name", "dof", "T", "H", "f_min", "f_max", "tau")
SURVEYED = vehicles()[-1]


@pytest.fixture(scope="module")
def found() -> list[ProvenProblem]:
    taken = (load_vehicle("ukwial"), load_vehicle("supply-vessel").with_fault(1), SURVEYED)
    return [problem for vehicle in taken for problem in problems(vehicle, QUICK, 10)]


@pytest.fixture(scope="module")
def folder(found: list[ProvenProblem], tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("pyarrow", reason="needs the extra problems")
    written = tmp_path_factory.mktemp("problems")
    write_problems(written, found)
    return written


def prove(file: Path) -> subprocess.CompletedProcess[str]:
    """Run the script of docs/problems.md on a file, without this project."""
    (script,) = blocks(DOCS / "problems.md", "python")
    command = [sys.executable, "-I", "-c", script, str(file)]
    return subprocess.run(command, cwd=file.parent, check=False, capture_output=True, text=True)


def test_every_answer_is_proven_by_the_script_of_the_page(found: list[ProvenProblem], folder: Path) -> None:
    done = prove(folder / "problems.jsonl")
    assert done.returncode == 0, done.stderr
    assert {problem.label for problem in found} == {"inactive", "active", "boundary", "infeasible"}
    assert any(problem.T_strong for problem in found)


@pytest.mark.long
@pytest.mark.parametrize("vehicle", vehicles(), ids=lambda vehicle: vehicle.name)
def test_every_answer_of_every_vehicle_and_sequence_is_proven(vehicle: Vehicle, tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="needs the extra problems")
    write_problems(tmp_path, list(problems(vehicle, sequences())))
    done = prove(tmp_path / "problems.jsonl")
    assert done.returncode == 0, done.stderr


def larger(problem: dict[str, Any], key: str, by: float) -> None:
    problem[key] = (np.array(problem[key]) + by * np.abs(problem[key]).max()).tolist()


WRONG: dict[str, tuple[str, Callable[[dict[str, Any]], None]]] = {
    "thrusts": ("active", lambda p: larger(p, "f", 1e-6)),
    "multipliers": ("active", lambda p: larger(p, "y", 1e-3)),
    "no answer": ("active", lambda p: p.update(f=None, farkas=p["edge_normal"])),
    "an answer": ("infeasible", lambda p: p.update(f=p["edge_f"], y=[0.0] * 3, z=[0.0] * 4)),
    "alpha": ("infeasible", lambda p: p.update(alpha=p["alpha"] * (1 + 1e-6))),
    "a facet": ("infeasible", lambda p: p.update(edge_normal=(-np.array(p["edge_normal"])).tolist())),
    "the edge": ("infeasible", lambda p: larger(p, "edge_f", -1e-6)),
}


@pytest.mark.parametrize("what", WRONG)
def test_the_script_refuses_a_line_in_which_something_is_wrong(
    what: str, found: list[ProvenProblem], tmp_path: Path
) -> None:
    label, spoil = WRONG[what]
    problem = next(each for each in found if each.vehicle == "ukwial" and each.label == label)
    line = msgspec.to_builtins(problem)
    spoil(line)
    (tmp_path / "line.jsonl").write_text(json.dumps(line))
    done = prove(tmp_path / "line.jsonl")
    assert done.stderr.splitlines()[-1] == f"AssertionError: {problem.name}"


def test_shares_and_alpha_are_those_of_other_ways_to_them(found: list[ProvenProblem]) -> None:
    """``scaled`` goes towards a demand, and a linear program says how far one may go."""
    ukwial = load_vehicle("ukwial")
    scaled = {vehicle.name: build("scaled", vehicle) for vehicle in (ukwial, SURVEYED)}
    for problem in found:
        if problem.vehicle in scaled:
            (share,) = scaled[problem.vehicle](problem.tau, problem.f_min, problem.f_max).share
            assert share == pytest.approx(problem.share, abs=1e-9)
        if problem.vehicle == "ukwial" and problem.alpha is not None:
            limits = np.array(problem.f_min), np.array(problem.f_max)
            assert alpha_max_lp(ukwial, problem.tau, *limits) == pytest.approx(problem.alpha, rel=1e-8)


def test_parquet_and_json_lines_hold_the_same_under_one_schema(
    found: list[ProvenProblem], folder: Path
) -> None:
    from pyarrow import parquet

    table = parquet.read_table(folder / "problems.parquet")
    lines = (folder / "problems.jsonl").read_bytes().splitlines()
    assert [msgspec.json.decode(line, type=ProvenProblem) for line in lines] == found
    assert table.to_pylist() == [json.loads(line) for line in lines]
    assert table.schema.equals(columns(), check_metadata=True)
    described = json.loads((folder / "schema.json").read_text())["$defs"]["ProvenProblem"]["properties"]
    assert list(described) == table.schema.names
    for field in table.schema:
        assert (field.metadata or {}).get(b"description", b"").decode() == described[field.name].get(
            "description", ""
        )


@pytest.mark.long
def test_inputs_are_the_same_bytes_with_another_processor_s_kernels(tmp_path: Path) -> None:
    program = (
        "import sys, msgspec; from bench.demands.problems import *\n"
        "for v in vehicles():\n for p in problems(v, ('active', 'boundary', 'hard', 'mission', 'slew'), 9):\n"
        f"  print(msgspec.json.encode([getattr(p, key) for key in {INPUTS}]).decode())"
    )
    printed = [
        subprocess.run(
            [sys.executable, "-c", program],
            cwd=ROOT,
            env=os.environ | {"OPENBLAS_CORETYPE": kernels},
            check=True,
            capture_output=True,
        ).stdout
        for kernels in ("Prescott", "Haswell")
    ]
    assert printed[0] == printed[1] != b""


def test_qpbenchmark_gets_the_attainable_problems_digit_for_digit(found: list[ProvenProblem]) -> None:
    posed = {problem.name: for_qpbenchmark(problem) for problem in found}
    for problem in found:
        row = posed[problem.name]
        if problem.f is None or problem.vehicle.startswith("bluerov2-heavy"):  # rank 5 of 6 after failures
            assert row is None or np.linalg.matrix_rank(problem.T) == len(problem.T)
            continue
        assert row is not None
        unit = row["ub"][0] / problem.f_max[0]
        x = np.array(problem.f) * unit
        A = row["A"].reshape(len(problem.tau), -1)
        np.testing.assert_allclose(A @ x, row["b"], rtol=0, atol=1e-9)
        for scaled, own in ((row["A"], np.ravel(problem.T)), (row["P"], np.ravel(problem.H))):
            assert np.array_equal(np.frexp(scaled)[0], np.frexp(own)[0])
    assert any(posed.values())


def test_qpbenchmark_runs_the_test_set_by_its_own_command(found: list[ProvenProblem], tmp_path: Path) -> None:
    pytest.importorskip("qpbenchmark", reason="needs the extra qpbenchmark")
    write_problems(tmp_path, found[::5])
    command = [sys.executable, "-m", "qpbenchmark.benchmark", "--results-path=results.csv"]
    asked = ["thrustbench_problems.py", "run", "--solver=daqp", "--author=me"]
    subprocess.run([*command, *asked], cwd=tmp_path, check=True, capture_output=True)
    _, *lines = (tmp_path / "results.csv").read_text().splitlines()
    assert len(lines) == 4 * sum(for_qpbenchmark(problem) is not None for problem in found[::5]) > 20
    assert all(",True," in line for line in lines)
