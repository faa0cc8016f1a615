"""Right answers come from the catalogue's references, best first, each in a process of its own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest

from bench.harness.plan import RunSettings
from bench.harness.run import run
from bench.record import Record, read
from tests.places import ROOT

BROKEN = {
    "crashes": "import ctypes\n\ndef build(vehicle):\n    ctypes.string_at(0)\n",
    "answers_half": (
        "from alloc.methods.pinv import build as pinv\n\n"
        "class Half:\n"
        "    def __init__(self, vehicle):\n        self.pinv = pinv(vehicle)\n"
        "    def many(self, taus):\n        return self.pinv.many(taus[::2])\n\n"
        "def build(vehicle):\n    return Half(vehicle)\n"
    ),
}
MEASURE = """
import sys; from pathlib import Path
from bench.harness.plan import RunSettings; from bench.harness.run import run
settings = RunSettings(
    vehicles=("ukwial",), demands=("active",), methods=("nullspace", "qp/piqp"),
    levels=("tight",), n_demands=4, budget_ms=0, repeats=1
)
run(settings, Path("out"), resume=False, watch=lambda progress: None)
"""
"""A run without its report, which takes longer than all the rest."""


def measured(folder: Path, **changes: Any) -> Record:
    """The record of a small run in this process."""
    settings = RunSettings(vehicles=("ukwial",), demands=("active",), n_demands=4, budget_ms=0, repeats=1)
    run(msgspec.structs.replace(settings, **changes), folder, resume=False, watch=lambda progress: None)
    return read(folder)


@pytest.mark.parametrize("how", ["crashes", pytest.param("answers_half", marks=pytest.mark.long)])
def test_a_reference_that_goes_wrong_gives_way_to_the_next_one(tmp_path: Path, how: str) -> None:
    for package in ("alloc", "bench"):
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "alloc" / "methods" / "nullspace.py").write_text(f'FORMULATION = "hard"\n{BROKEN[how]}')
    own = {**os.environ, "PYTHONPATH": str(tmp_path)}
    subprocess.run([sys.executable, "-c", MEASURE], cwd=tmp_path, env=own, check=True, timeout=100)
    record = read(tmp_path / "out")
    (problem,) = record.problems
    assert problem.reference == "qp/daqp"
    status = {cell.key.method: cell.status for cell in record.cells}
    assert status["nullspace"] == ("crashed" if how == "crashes" else "failed")
    assert [unserved.method for unserved in record.capabilities[0].unserved] == ["nullspace"]
    agrees = {c.key.method: c.judged.agrees for c in record.cells if c.judged is not None}
    assert agrees["qp/piqp"] is True  # it is held to the right answers of the second reference


@pytest.mark.usefixtures("bare_runs")
def test_a_plug_in_named_as_a_reference_is_held_to_the_catalogue_s(tmp_path: Path) -> None:
    plugin = tmp_path / "nullspace.py"
    plugin.write_text(
        "from alloc import Allocation\n"
        "from alloc.methods.nullspace import build as exact\n\n"
        'FORMULATION = "hard"\n\n'
        "class Off:\n"
        '    formulation, limited, tolerance = "hard", True, 1e-9\n'
        "    def __init__(self, vehicle):\n        self.exact = exact(vehicle)\n"
        "    def __call__(self, tau):\n"
        "        f, *rest = self.exact(tau)\n        return Allocation(0.999 * f, *rest)\n\n"
        "def build(vehicle):\n    return Off(vehicle)\n"
    )
    record = measured(tmp_path / "out", plugins=(str(plugin),))
    (cell,) = [cell for cell in record.cells if cell.key.method == "nullspace"]
    assert cell.judged is not None
    assert cell.judged.agrees is False


@pytest.mark.usefixtures("bare_runs")
def test_a_time_limit_too_short_for_any_cell_is_no_limit_for_references(tmp_path: Path) -> None:
    record = measured(tmp_path / "out", methods=("pinv",), time_limit_s=0.001)
    assert [problem.reference for problem in record.problems] == ["nullspace"]
