""".ci/elsewhere finds what compares computed numbers with stored text to the last digit, nothing else."""

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.places import ROOT, other_pytest

CPU = Path("/proc/cpuinfo")
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(
        platform.machine() != "x86_64" or not CPU.exists() or "avx2" not in CPU.read_text(),
        reason="has no two kinds of OpenBLAS's kernels to compare",
    ),
]
COMPUTED = """\
import numpy as np

def computed():
    A = np.random.default_rng(1).normal(size=(64, 64))
    return (A @ A).tolist()
"""
LAST_DIGIT = "def test_planted():\n    assert repr(computed()) == {stored!r}\n"
TOLERANT = "def test_planted():\n    assert np.allclose(computed(), {stored})\n"
PROCESS = "import subprocess\n\ndef test_planted():\n    subprocess.run(['false'], check=True)\n"


def stored(kernels: str) -> str:
    """Output of those kernels, to the last digit."""
    command = [sys.executable, "-c", f"{COMPUTED}\nprint(repr(computed()))"]
    environment = os.environ | {"OPENBLAS_CORETYPE": kernels}
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.strip()


def elsewhere(folder: Path, test: str, *where: str) -> subprocess.CompletedProcess[str]:
    """The planted test, run by .ci/elsewhere in a copy of what it needs of the tree."""
    (folder / ".ci").mkdir()
    (folder / "tests").mkdir()
    shutil.copy(ROOT / ".ci" / "elsewhere", folder / ".ci")
    shutil.copy(ROOT / "tests" / "in_process.py", folder / "tests")
    (folder / ".venv").symlink_to(sys.prefix)
    (folder / "test_planted.py").write_text(test)
    return subprocess.run(
        [folder / ".ci" / "elsewhere", *where, "--", "-q", "test_planted.py"],
        env=other_pytest() | {"OPENBLAS_CORETYPE": "Haswell", "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
    )


def test_a_comparison_to_the_last_digit_is_red_under_other_kernels(tmp_path: Path) -> None:
    run = elsewhere(tmp_path, COMPUTED + LAST_DIGIT.format(stored=stored("Haswell")), "Nehalem", "numpy")
    assert run.returncode == 1, run.stdout + run.stderr
    assert "1 failed" in run.stdout


def test_the_same_comparison_is_green_with_the_kernels_that_it_was_written_with(tmp_path: Path) -> None:
    run = elsewhere(tmp_path, COMPUTED + LAST_DIGIT.format(stored=stored("Nehalem")), "Nehalem")
    assert run.returncode == 0, run.stdout + run.stderr
    assert "1 passed" in run.stdout


def test_a_comparison_within_a_tolerance_is_green_under_other_kernels(tmp_path: Path) -> None:
    run = elsewhere(tmp_path, COMPUTED + TOLERANT.format(stored=stored("Haswell")), "Nehalem", "numpy")
    assert run.returncode == 0, run.stdout + run.stderr
    assert "1 passed" in run.stdout


def test_kernels_that_all_other_runs_have_are_left_out(tmp_path: Path) -> None:
    run = elsewhere(tmp_path, COMPUTED + LAST_DIGIT.format(stored="0"), "Haswell")
    assert run.returncode == 0
    assert "elsewhere: Haswell's kernels are those of all other runs here" in run.stdout


def test_what_starts_a_process_is_skipped_under_other_kernels(tmp_path: Path) -> None:
    run = elsewhere(tmp_path, PROCESS, "Nehalem")
    assert run.returncode == 0, run.stdout + run.stderr
    assert "1 skipped" in run.stdout
