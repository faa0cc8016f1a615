"""The tests' own temporary folder: what is left there is named, and fails the run."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.places import ROOT

LEAVES = "import tempfile\ndef test_it() -> None:\n    {0}tempfile.mkdtemp(prefix='forgotten-')\n"


@pytest.mark.parametrize(("mark", "code"), [("", 1), ("assert not '' # ", 0)])
def test_a_folder_that_a_test_leaves_is_named_and_fails_the_run(mark: str, code: int, tmp_path: Path) -> None:
    (tmp_path / "test_leaves.py").write_text(LEAVES.format(mark))
    environment = {key: value for key, value in os.environ.items() if key != "PYTEST_XDIST_WORKER"}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "tests.conftest", str(tmp_path)],
        cwd=ROOT,
        env={**environment, "TMPDIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stdout
    assert ("tests left forgotten-" in done.stdout) is bool(code)
    assert not list(tmp_path.glob("thrustbench-tests-*"))
