"""docs/embedded.md's way from a vehicle file to a record, typed step by step as it stands there."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.emulators import available
from tests.places import DOCS

HARDWARE = "stty "
"""First word of a command that needs a board and reads its line; the desk's log stands in for its output."""


def steps() -> list[str]:
    """The commands of the page's hour, in order."""
    text = (DOCS / "embedded.md").read_text(encoding="utf-8")
    hour = text.partition("## In an hour")[2].partition("\n### ")[0]
    blocks = re.findall(r"```text\n(.*?)```", hour, re.DOTALL)
    lines = [line.removeprefix("$ ") for block in blocks for line in block.splitlines()]
    return [line for line in lines if re.match(r"(thrustbench|make|stty) ", line)]


@pytest.mark.long
def test_the_hour_can_be_typed_as_it_stands(tmp_path: Path) -> None:
    available("cortex-m4f")
    if not shutil.which("make"):
        pytest.skip("needs make")
    program = tmp_path / "bin/thrustbench"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m bench "$@"\n')
    program.chmod(0o755)
    root = str(DOCS.parent)
    env = os.environ | {"PATH": f"{program.parent}:{os.environ['PATH']}", "PYTHONPATH": root}
    typed = steps()
    assert len(typed) == 11
    for step in typed:
        if step.startswith(HARDWARE):
            shutil.copy(tmp_path / "firmware/build/posix/LOG", tmp_path / "LOG")
            continue
        if "PORT=cortex-m " in step:  # the page says to fill it in first
            port = tmp_path / "firmware/ports/cortex_m.c"
            port.write_text(re.sub(r"#error .*\n", "", port.read_text()))
        done = subprocess.run(
            step, shell=True, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=120
        )
        assert done.returncode == 0, f"{step}: {done.stderr}"
    assert (
        "take scaled as generated C; exact, answers every demand. It takes under"
        in subprocess.run(
            "thrustbench size desk --rate 200",
            shell=True,
            cwd=tmp_path,
            env=env,
            capture_output=True,
            text=True,
        ).stdout
    )
    assert (tmp_path / "emulated/emulation.csv").exists()
    assert (tmp_path / "firmware/build/cortex-m/board.a").exists()
    assert (tmp_path / "both/report.html").exists()
