"""The gate on real trees in real repositories: what it finds, what it lets pass, what it refuses.

Times are not asserted here; ``python -m bench.studies.gate_check`` does that, from ``.ci/run``.
"""

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from threading import Timer
from time import monotonic, sleep
from typing import Any

import psutil
import pytest
from click.testing import CliRunner, Result

from bench.commands.gate import command
from bench.gate import instructions, trees
from bench.gate.cells import chosen
from bench.gate.record import GateCell
from bench.gate.side import Died, Refused, Side, SourceTree
from bench.studies import gate_check
from bench.studies.injection import CLOSED_FORMS, delete_method, scale_thrusts, slow_down

FEW = ("--pairs", "2", "--no-instructions", "--cells", "ukwial:pinv", "--cells", "ukwial:svd")


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A copy of this tree with one commit."""
    tree = tmp_path / "repository"
    gate_check.copy(tree)
    return tree


def gate(repository: Path, change: Callable[[Path], object] = lambda _: None, *options: str) -> Result:
    """The gate's answer to one more commit."""
    change(repository)
    gate_check.commit(repository, "head")
    arguments = ["HEAD~1", "HEAD", "--repo", str(repository), *FEW, *options]
    # A command's return value is what the program's main makes its exit code.
    return CliRunner().invoke(command, arguments, standalone_mode=False)


def test_a_commit_that_changes_only_a_document_passes_at_once_and_says_why(repository: Path) -> None:
    found = gate(repository, lambda tree: (tree / "README.md").write_text("Anything."))
    assert found.return_value == 0
    assert found.stdout.startswith("## ✅ Gate: pass at once: alloc/ and the requirements are the same")


def test_wrong_answers_fail_without_any_time_being_looked_at(repository: Path, tmp_path: Path) -> None:
    out = tmp_path / "gate.json"
    found = gate(repository, lambda tree: scale_thrusts(tree, 1.001), "--json", str(out))
    assert found.return_value == 1
    assert "regression: answers are wrong" in found.stdout
    data = json.loads(out.read_text())
    assert data["verdict"]["exit_code"] == 1
    assert [f["cell"] for f in data["verdict"]["findings"]] == ["ukwial:pinv:-"]
    assert "N from the optimum, beyond its promise" in data["verdict"]["findings"][0]["what"]
    assert "time" not in data["record"]["seconds"]


def test_a_deleted_method_fails_and_is_named(repository: Path) -> None:
    found = gate(repository, lambda tree: delete_method(tree, "svd"))
    assert found.return_value == 1
    assert "regression: cells are gone" in found.stdout
    assert "| `ukwial:svd:-` | gone:" in found.stdout


def test_a_tree_that_cannot_be_imported_fails_with_the_reason(repository: Path) -> None:
    found = gate(
        repository, lambda tree: (tree / "alloc" / "closed_forms" / "linear.py").write_text("def broken(")
    )
    assert found.return_value == 1
    assert "alloc can't be imported: SyntaxError" in found.stdout


def test_a_method_that_brings_its_process_down_fails_alone(repository: Path) -> None:
    def crash(tree: Path) -> None:
        with (tree / "alloc" / "methods" / "svd.py").open("a") as file:
            file.write("\n\ndef build(vehicle):\n    import os\n    os.abort()\n")

    found = gate(repository, crash)
    assert "| `ukwial:svd:-` | gone: head: ended with SIGABRT" in found.stdout
    assert "pinv" not in found.stdout


def test_a_method_that_fails_on_both_sides_is_mentioned_not_dropped(repository: Path) -> None:
    with (repository / "alloc" / "methods" / "svd.py").open("a") as file:
        file.write("\n\ndef build(vehicle):\n    import os\n    os.abort()\n")
    gate_check.commit(repository, "it was so before")
    found = gate(repository, lambda _: None, "--always")
    assert "- fails on both sides, so not compared: `ukwial:svd:-`: head: ended with SIGABRT" in found.stdout


def test_a_new_method_is_mentioned_and_the_rest_is_timed(repository: Path) -> None:
    def add(tree: Path) -> None:
        (tree / "alloc" / "methods" / "another.py").write_text(
            '"""Another."""\nfrom alloc.methods.pinv import *\n'
        )

    found = gate(repository, add, "--cells", "ukwial:another")
    assert "new: `ukwial:another:-`" in found.stdout
    assert "| `ukwial:pinv:-` |" in found.stdout


def test_a_vehicle_whose_limits_changed_is_judged_by_its_own_numbers(repository: Path) -> None:
    def weaken(tree: Path) -> None:
        file = tree / "alloc" / "vehicles" / "ukwial.yaml"
        file.write_text(file.read_text().replace("f_max: 250", "f_max: 200"))

    found = gate(repository, weaken, "--cells", "ukwial:nullspace")
    assert "ukwial: its numbers differ, so each side is judged by its own" in found.stdout
    assert "| `ukwial:nullspace:-` |" in found.stdout
    assert "wrong" not in found.stdout


def test_a_vehicle_that_no_longer_loads_is_a_regression_and_not_bad_usage(repository: Path) -> None:
    def spoil(tree: Path) -> None:
        (tree / "alloc" / "vehicles" / "ukwial.yaml").write_text("name: ukwial\n")

    found = gate(repository, spoil)
    assert found.return_value == 1
    assert "| `ukwial:pinv:-` | gone: VehicleError" in found.stdout


def test_half_as_slow_again_is_found_by_time_alone(repository: Path) -> None:
    found = gate(repository, lambda tree: slow_down(tree, CLOSED_FORMS, 2000), "--pairs", "3")
    # Two stages of three pairs each are few: the control cells may well move meanwhile.
    assert found.return_value in (1, 3)
    assert re.search(r"\| `ukwial:pinv:-` \| .* µs, \+\d+", found.stdout)


@pytest.mark.parametrize("dead", ["base", "head"])
def test_where_one_side_dies_under_valgrind_the_other_is_not_counted_to_the_end(
    dead: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted = []

    class Counting(AbstractContextManager[Any]):
        def __init__(self, tree: SourceTree, started: list[Any], **_: Any) -> None:
            self.name, self.killed = tree.path.name, False
            started.append(self)

        def kill(self) -> None:
            self.killed = True

        def ask(self, do: str, cell: str = "", **_: Any) -> None:
            if do == "count":
                if self.name == dead:
                    sleep(0.2)  # until the other has begun
                    raise Died(dead, "an instruction that valgrind does not know")
                if self.killed:
                    raise Died(self.name, "was ended")
                counted.append(cell)
                sleep(0.02)

        def __exit__(self, *_: object) -> None:
            pass

    monkeypatch.setattr(instructions, "Side", Counting)
    cells = [GateCell("control", str(i)) for i in range(100)]
    both = SourceTree(tmp_path / "base"), SourceTree(tmp_path / "head")
    with pytest.raises(Died):
        instructions.count(cells, both, {"control": [[0.0]]}, hash_seed=0)
    assert len(counted) < len(cells) / 2


def test_without_valgrind_it_says_so(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(instructions, "missing", lambda: "valgrind is missing, install it")
    found = gate(repository, lambda _: None, "--always", "--instructions")
    assert "valgrind is missing, install it" in found.stdout


def test_a_users_own_method_is_gated_too(repository: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text('"""Mine."""\nfrom alloc.methods.pinv import FORMULATION, build\n')
    found = gate(repository, lambda _: None, "--always", "--plugin", str(mine), "--cells", "ukwial:mine")
    assert "| `ukwial:mine:-` |" in found.stdout


def test_a_spent_budget_is_inconclusive(repository: Path) -> None:
    # A pair of processes takes a third of a second at best: no machine does a thousand in one.
    found = gate(repository, lambda _: None, "--always", "--pairs", "1000", "--budget", "1")
    assert found.return_value == 3
    assert "❔ Gate: inconclusive: the budget of 1 s was spent" in found.stdout


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "give BASE or --base-path"),
        (["HEAD", "--base-path", "."], "give BASE or --base-path"),
        (["HEAD", "HEAD", "--head-path", "."], "give HEAD or --head-path"),
        (["no-such-revision"], "no-such-revision"),
        (["--base-path", "tests", "--head-path", "."], "tests: holds no package 'alloc'"),
    ],
)
def test_bad_usage_is_one_line(arguments: list[str], says: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(gate_check.ROOT)
    found = CliRunner().invoke(command, arguments, standalone_mode=False)
    assert says in str(found.exception)


def test_patterns_that_fit_nothing_are_bad_usage(repository: Path) -> None:
    arguments = ["HEAD", "--repo", str(repository), "--always", "--cells", "ukwial:nix"]
    found = CliRunner().invoke(command, arguments, standalone_mode=False)
    assert "no cell of either side fits ukwial:nix" in str(found.exception)


def test_patterns_choose_cells_with_and_without_the_start() -> None:
    cells = [["ukwial", "pinv", "-"], ["ukwial", "qp/daqp", "warm"], ["nautilus", "pinv", "-"]]
    assert [c.name for c in chosen(cells, ["ukwial:pinv"])] == ["ukwial:pinv:-"]
    assert [c.name for c in chosen(cells, ["*:qp/*:warm", "naut*"])] == [
        "ukwial:qp/daqp:warm",
        "nautilus:pinv:-",
    ]


def test_requirements_are_compared_and_comments_are_not(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text(
        '[project]\ndependencies = ["numpy"]\n[tool.ruff]\nline-length = 1\n'
    )
    (tmp_path / "constraints.txt").write_text("# a comment\nnumpy==2.0\n")
    assert trees.requirements(tmp_path) == ["numpy", "numpy==2.0"]


def test_trees_with_other_requirements_get_environments_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for side, needs in (("base", "numpy"), ("head", "numpy>=2")):
        (tmp_path / side / "alloc").mkdir(parents=True)
        (tmp_path / side / "pyproject.toml").write_text(f'[project]\ndependencies = ["{needs}"]\n')
    monkeypatch.setattr(trees, "_environment", lambda tree, at: f"python of {tree.name} in {at.name}")
    base, head, at = (tmp_path / name for name in ("base", "head", "environments"))
    assert trees.interpreters(base, head, at) == ("python of base in base", "python of head in head")
    assert trees.interpreters(base, base, at) == (sys.executable, sys.executable)


@pytest.mark.parametrize(
    ("text", "says"),
    [(None, "says in no pyproject.toml what it requires"), ("[project", "pyproject.toml can't be read")],
)
def test_a_tree_that_does_not_say_what_it_requires_is_named(
    text: str | None, says: str, tmp_path: Path
) -> None:
    for side in ("base", "head"):
        (tmp_path / side / "alloc").mkdir(parents=True)
    (tmp_path / "base" / "pyproject.toml").write_text('[project]\ndependencies = ["numpy"]\n')
    if text is not None:
        (tmp_path / "head" / "pyproject.toml").write_text(text)
    base, head = tmp_path / "base", tmp_path / "head"
    with pytest.raises(trees.BadTree, match=f"^head: {says}"):
        trees.interpreters(head, base, tmp_path / "environments")


def test_the_measured_library_is_the_trees_and_not_the_gates(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    with pytest.raises(Refused, match="alloc"):
        Side(SourceTree(tmp_path / "elsewhere"))


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("printf '{\"value\": tr'; exit 3", "ended with exit code 3"),
        ("printf '\\377\\n' >&2; exit 3", "ended with exit code 3: \ufffd"),
    ],
    ids=["in the middle of its reply", "with a word in no encoding"],
)
def test_however_a_process_dies_it_is_said_how(script: str, says: str, tmp_path: Path) -> None:
    interpreter = tmp_path / "python"
    interpreter.write_text(f"#!/bin/sh\nread order\n{script}\n")
    interpreter.chmod(0o755)
    with pytest.raises(Died) as caught:
        Side(SourceTree(tmp_path, str(interpreter)))
    assert says in str(caught.value)


def deaf(folder: Path) -> SourceTree:
    """A tree whose process hears neither Ctrl-C nor the end of its orders, like a solver that hangs."""
    interpreter = folder / "python"
    interpreter.write_text("#!/bin/sh\ntrap '' INT\nwhile true; do sleep 0.1; done\n")
    interpreter.chmod(0o755)
    return SourceTree(folder, str(interpreter))


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("moment", ["as it starts", "before its first order"])
def test_ctrl_c_before_a_process_has_its_first_order_ends_it_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str
) -> None:
    start = subprocess.Popen.__init__

    def interrupted(*arguments: Any, **named: Any) -> None:
        if moment == "as it starts":
            start(*arguments, **named)
        signal.raise_signal(signal.SIGINT)

    if moment == "as it starts":
        monkeypatch.setattr(subprocess.Popen, "__init__", interrupted)
    else:
        monkeypatch.setattr("bench.gate.side.Timer", interrupted)
    before, started = set(psutil.Process().children()), monotonic()
    with pytest.raises(KeyboardInterrupt):
        Side(deaf(tmp_path))
    assert monotonic() - started < 10
    assert set(psutil.Process().children()) == before


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("after_s", [0.0, 0.001, 0.003, 0.01, 0.3])
def test_ctrl_c_ends_a_process_that_never_replies_at_once(tmp_path: Path, after_s: float) -> None:
    before = set(psutil.Process().children())
    started = monotonic()

    def interrupted() -> None:
        Timer(after_s, os.kill, [os.getpid(), signal.SIGINT]).start()
        Side(deaf(tmp_path))

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert monotonic() - started < 10
    assert set(psutil.Process().children()) == before


def test_a_process_that_does_not_reply_in_time_is_ended() -> None:
    with Side(SourceTree(gate_check.ROOT)) as side:
        side.ask("control", cell="control:loop:-", kind="loop")
        side.ask("keep", vehicle="control", taus=[[0.0]])
        with pytest.raises(Died, match=r"no reply within 0\.2 s"):
            side.ask("block", cell="control:loop:-", vehicle="control", rounds=10**9, timeout=0.2)
