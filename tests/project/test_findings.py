"""Scripts in ``findings``: their form. What they find is asked outside CI, with the packages of the day."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.places import ROOT

SCRIPTS = sorted((ROOT / "findings").iterdir())


def test_there_are_some() -> None:
    assert len(SCRIPTS) >= 11
    assert {script.suffix for script in SCRIPTS} == {".sh"}


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_finding_says_guess_version_and_consequence_and_stands_alone(script: Path) -> None:
    text = script.read_text(encoding="utf-8")
    header = text.partition("set -euo pipefail")[0]
    assert re.match(r"#!/usr/bin/env bash\n# \S.*\.\n#\n# Guess: ", header)
    assert re.search(r"^# Seen \(.*\d+\.\d+.*\): ", header, re.MULTILINE)
    assert re.search(r"^# Consequence: ", header, re.MULTILINE)
    assert "folder=$(mktemp -d); trap 'rm -rf \"$folder\"' EXIT" in text
    assert not re.search(r"thrustbench|\bimport (alloc|bench)\b|\bfrom (alloc|bench)\b", text)
    for wanted in re.findall(r"pip\" install [^\n]*--disable-pip-version-check ([^\n]*)", text):
        assert re.match(r'"?[a-z-]+==(\d+\.\d+\.\d+|\$version)"?', wanted), wanted
    assert max(map(len, text.splitlines())) <= 130


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_a_finding_can_be_run_and_parsed(script: Path) -> None:
    assert script.stat().st_mode & 0o111
    assert subprocess.run(["bash", "-n", str(script)], check=False).returncode == 0
