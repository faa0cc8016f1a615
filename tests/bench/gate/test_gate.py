"""The gate on real trees in real repositories: what it finds, what it lets pass, what it refuses.

Times are not asserted here; ``python docs/studies/gate_check.py`` asserts them, from ``.ci/run``.
"""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

import gate_check
from bench.gate import run
from injection import CLOSED_FORMS, delete_method, scale_thrusts, slow_down
from tests.gate_sides import run_gate

pytestmark = pytest.mark.usefixtures("few_demands")

FEW = ("--pairs", "2", "--no-instructions")
CELLS = ("--cells", "ukwial:pinv", "--cells", "ukwial:svd")


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A copy of this tree with one commit."""
    tree = tmp_path / "repository"
    gate_check.copy(tree)
    return tree


def gate(
    repository: Path,
    change: Callable[[Path], object] = lambda _: None,
    *options: str,
    cells: tuple[str, ...] = CELLS,
) -> Result:
    """Verdict of the gate on a commit with that change."""
    change(repository)
    gate_check.commit(repository, "head")
    return run_gate("HEAD~1", "HEAD", "--repo", repository, *FEW, *cells, *options)


def test_a_commit_that_changes_only_a_document_passes_at_once_and_says_why(repository: Path) -> None:
    result = gate(repository, lambda tree: (tree / "README.md").write_text("Anything."))
    assert result.return_value == 0
    assert result.stdout.startswith("## ✅ Gate: pass at once: alloc/ and the requirements are the same")


def test_wrong_answers_fail_before_any_time_is_measured(repository: Path, tmp_path: Path) -> None:
    out = tmp_path / "gate.json"
    result = gate(repository, lambda tree: scale_thrusts(tree, 1.001), "--json", str(out))
    assert result.return_value == 1
    assert "regression: answers are wrong" in result.stdout
    data = json.loads(out.read_text())
    assert data["verdict"]["exit_code"] == 1
    assert [f["cell"] for f in data["verdict"]["findings"]] == ["ukwial:pinv:-"]
    assert "N from the optimum, beyond its promise" in data["verdict"]["findings"][0]["what"]
    assert "time" not in data["record"]["seconds"]


def test_a_deleted_method_fails_the_gate_and_is_named_in_a_terminal_and_folded_in_a_file(
    repository: Path, tmp_path: Path
) -> None:
    out = tmp_path / "gate.md"
    result = gate(repository, lambda tree: delete_method(tree, "svd"), "--markdown", str(out))
    assert result.return_value == 1
    assert "regression: cells are gone" in result.stdout
    assert "| `ukwial:svd:-` | gone:" in result.stdout
    assert "<" not in result.stdout
    assert "<details><summary>Commits</summary>" in out.read_text()


def test_a_tree_that_cannot_be_imported_fails_the_gate_with_the_reason(repository: Path) -> None:
    result = gate(
        repository, lambda tree: (tree / "alloc" / "closed_forms" / "linear.py").write_text("def broken(")
    )
    assert result.return_value == 1
    assert "can't be imported: SyntaxError" in result.stdout


def abort(tree: Path) -> None:
    """Let ``svd`` end its process."""
    with (tree / "alloc" / "methods" / "svd.py").open("a") as file:
        file.write("\n\ndef build(vehicle):\n    import os\n    os.abort()\n")


def test_a_method_that_ends_its_process_is_the_only_one_that_fails(repository: Path) -> None:
    result = gate(repository, abort)
    assert "| `ukwial:svd:-` | gone: head: ended with SIGABRT" in result.stdout
    assert "pinv" not in result.stdout


def test_what_comes_together_is_told_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`svd` aborts on both sides, `another` is new, a user's method is asked for, no valgrind is here."""
    tree, mine = tmp_path / "repository", tmp_path / "mine.py"
    gate_check.copy(tree)
    abort(tree)
    gate_check.commit(tree, "it was so before")
    another = '"""Another."""\nfrom alloc.methods.pinv import *\n'
    mine.write_text('"""Mine."""\nfrom alloc.methods.pinv import FORMULATION, build\n')
    options = ("--instructions", "--plugin", str(mine), "--cells", "ukwial:mine", "--cells", "ukwial:another")
    monkeypatch.setattr(run, "missing", lambda: "valgrind is missing, install it")
    said = gate(tree, lambda tree: (tree / "alloc/methods/another.py").write_text(another), *options).stdout
    assert "- fails on both sides, so not compared: `ukwial:svd:-`: head: ended with SIGABRT" in said
    assert "new: `ukwial:another:-`" in said
    assert "| `ukwial:pinv:-` |" in said
    assert "| `ukwial:mine:-` |" in said
    assert "valgrind is missing, install it" in said


def test_a_vehicle_whose_limits_changed_is_judged_by_its_own_numbers(repository: Path) -> None:
    def weaken(tree: Path) -> None:
        file = tree / "alloc" / "vehicles" / "ukwial.yaml"
        file.write_text(file.read_text().replace("f_max: 250", "f_max: 200"))

    result = gate(repository, weaken, cells=("--cells", "ukwial:nullspace"))
    assert "ukwial: its numbers differ, so each side is judged by its own" in result.stdout
    assert "| `ukwial:nullspace:-` |" in result.stdout
    assert "wrong" not in result.stdout


def test_a_vehicle_that_no_longer_loads_is_a_regression_and_not_bad_usage(repository: Path) -> None:
    result = gate(repository, lambda tree: (tree / "alloc/vehicles/ukwial.yaml").write_text("name: ukwial\n"))
    assert result.return_value == 1
    assert "| `ukwial:pinv:-` | gone: VehicleError" in result.stdout


@pytest.mark.long
def test_a_slow_down_of_half_a_call_or_more_is_found_by_time_alone(repository: Path) -> None:
    result = gate(repository, lambda tree: slow_down(tree, CLOSED_FORMS, 2000), "--pairs", "3")
    # Two stages of three pairs are few: where a control cell moves meanwhile, the gate is inconclusive.
    assert result.return_value in (1, 3)
    assert re.search(r"\| `ukwial:pinv:-` \| .* µs, \+\d+", result.stdout)


def test_a_spent_budget_is_inconclusive(repository: Path) -> None:
    # A pair of processes takes a third of a second at best: no machine does a thousand in one.
    result = gate(repository, lambda _: None, "--always", "--pairs", "1000", "--budget", "1")
    assert result.return_value == 3
    assert (
        "❔ Gate: no answer got worse; inconclusive about time: the budget of 1 s was spent" in result.stdout
    )


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
def test_bad_usage_of_the_gate_names_what_to_give_instead(
    arguments: list[str], says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(gate_check.ROOT)
    assert says in str(run_gate(*arguments).exception)


@pytest.mark.parametrize(
    ("cells", "says"),
    [((), "ukwial:nix"), (CELLS, "ukwial:pinvv; there are ukwial:pinv:-")],
    ids=["alone", "among others that do"],
)
def test_a_pattern_that_fits_no_cell_is_bad_usage(
    repository: Path, cells: tuple[str, ...], says: str
) -> None:
    pattern = says.partition(";")[0]
    result = run_gate("HEAD", "--repo", repository, "--always", *cells, "--cells", pattern)
    assert f"no cell of either side fits {says}" in str(result.exception)
