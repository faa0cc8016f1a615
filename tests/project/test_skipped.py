"""CI is red where a test was skipped, or left out, by each of its runs."""

import subprocess
import sys
from pathlib import Path

from tests.places import ROOT, other_pytest

TESTS = """\
import os, pytest
from tests.not_asked import not_asked

def test_both():
    pass

@pytest.mark.parametrize("tool", ["a/b.py::c", "[gcc]"])
def test_one_leg(tool):
    if "SECOND" not in os.environ:
        pytest.skip("needs the second leg")

def test_expected():
    pytest.xfail("known")

def test_of_nobody():
    not_asked("another test does")
"""
NEVER = """
@pytest.mark.parametrize("tool", ["x y"])
def test_never(tool):
    pytest.skip("needs a unicorn")

def test_left_out():
    pass
"""
PLACE = other_pytest() | {"PYTHONPATH": str(ROOT)}


def found(folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(ROOT / ".ci" / "skipped.py"), "ran"]
    return subprocess.run(command, cwd=folder, env=PLACE, capture_output=True, text=True)


def test_what_all_runs_skipped_or_left_out_is_named_and_red_and_nothing_else_is(tmp_path: Path) -> None:
    planted = tmp_path / "test_planted.py"
    planted.write_text(TESTS + NEVER)
    pytest = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "not left_out"]
    for name, more in (("first", {}), ("second", {"SECOND": "1"})):
        subprocess.run([*pytest, f"--junitxml=ran/{name}.xml"], cwd=tmp_path, env=PLACE | more, check=True)
    red = found(tmp_path)
    assert red.returncode == 1
    assert red.stdout.splitlines() == [
        "skipped everywhere: test_planted.py::test_left_out: no run chose it",
        "skipped everywhere: test_planted.py::test_never[x y]: needs a unicorn",
    ]
    planted.write_text(TESTS)
    green = found(tmp_path)
    assert (green.returncode, green.stdout) == (0, "")
