"""The gate on a program with the line protocol: each side runs its own, and what takes longer shows."""

import re
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import gate_check
from bench.commands.init import command as init_command
from bench.gate.trees import BadTree
from tests.gate_sides import run_gate

pytestmark = pytest.mark.usefixtures("few_demands")
CUT = "say([min("
WRONG, SLOW = "say([-min(", "import time; time.sleep(2e-3); say([min("


@pytest.fixture
def starter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Files of ``init --language exec`` for four thrusters, in a repository with one commit."""
    monkeypatch.chdir(tmp_path)
    words = ["my-rov", "--like", "ukwial", "--language", "exec"]
    made = CliRunner().invoke(init_command, words, standalone_mode=False)
    assert made.exception is None, made.output
    gate_check.git(tmp_path, "init", "--quiet")
    gate_check.commit(tmp_path, "base")
    return tmp_path


def gate(folder: Path, method: str, line: str) -> Result:
    """Verdict of the gate on a head in which that line stands in place of the one that answers."""
    program = folder / "my_allocator"
    program.write_text(program.read_text().replace(CUT, line))
    gate_check.commit(folder, "head")
    options = ("--vehicle", str(folder / "my-rov.yaml"), "--pairs", "2")
    return run_gate("HEAD~1", "HEAD", "--repo", folder, "--method", method, *options)


@pytest.mark.long
@pytest.mark.parametrize(
    ("method", "line", "says"),
    [("./my_allocator", SLOW, "slower"), (f"exec:{sys.executable} my_allocator", WRONG, "wrong answer: ")],
    ids=["slow", "wrong"],
)
def test_each_side_runs_its_own_program(starter: Path, method: str, line: str, says: str) -> None:
    result = gate(starter, method, line)
    assert result.exception is None, result.output
    assert says in result.stdout
    assert re.search(r"^\| `[^`]*my-rov\.yaml:[^`]*my.allocator:-`", result.stdout, re.M)
    assert "instructions: " not in result.stderr


def test_a_command_that_both_sides_share_is_refused(starter: Path) -> None:
    command = "exec:ssh rov ./mine"
    error = gate(starter, command, WRONG).exception
    assert isinstance(error, BadTree)
    assert str(error).startswith(f"{command}: names no file of a side, so it would be compared with itself")
