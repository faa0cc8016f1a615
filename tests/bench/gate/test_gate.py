"""The gate on real trees in real repositories: what it finds, what it lets pass, what it refuses.

Times are not asserted here; ``python docs/studies/gate_check.py`` asserts them, from ``.ci/run``.
"""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import gate_check
from bench.commands.gate import command
from bench.gate import instructions
from bench.gate.trees import BadTree
from injection import CLOSED_FORMS, delete_method, scale_thrusts, slow_down

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
    """What the gate says of a commit with that change."""
    change(repository)
    gate_check.commit(repository, "head")
    arguments = ["HEAD~1", "HEAD", "--repo", str(repository), *FEW, *cells, *options]
    # A command's return value is what the program's main makes its exit code.
    return CliRunner().invoke(command, arguments, standalone_mode=False)


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


def test_a_method_that_ends_its_process_is_the_only_one_that_fails(repository: Path) -> None:
    def crash(tree: Path) -> None:
        with (tree / "alloc" / "methods" / "svd.py").open("a") as file:
            file.write("\n\ndef build(vehicle):\n    import os\n    os.abort()\n")

    result = gate(repository, crash)
    assert "| `ukwial:svd:-` | gone: head: ended with SIGABRT" in result.stdout
    assert "pinv" not in result.stdout


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What the gate prints of a commit in which several things come together, without valgrind.

    `svd` aborts on both sides, `another` is new, and a user's own method is asked for.
    """
    folder = tmp_path_factory.mktemp("mixed")
    tree, mine = folder / "repository", folder / "mine.py"
    gate_check.copy(tree)
    with (tree / "alloc" / "methods" / "svd.py").open("a") as file:
        file.write("\n\ndef build(vehicle):\n    import os\n    os.abort()\n")
    gate_check.commit(tree, "it was so before")

    def add(tree: Path) -> None:
        (tree / "alloc" / "methods" / "another.py").write_text(
            '"""Another."""\nfrom alloc.methods.pinv import *\n'
        )

    mine.write_text('"""Mine."""\nfrom alloc.methods.pinv import FORMULATION, build\n')
    options = ("--instructions", "--plugin", str(mine), "--cells", "ukwial:mine", "--cells", "ukwial:another")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(instructions, "missing", lambda: "valgrind is missing, install it")
        return gate(tree, add, *options).stdout


def test_a_method_that_fails_on_both_sides_is_mentioned_not_dropped(mixed: str) -> None:
    assert "- fails on both sides, so not compared: `ukwial:svd:-`: head: ended with SIGABRT" in mixed


def test_a_new_method_is_mentioned_and_the_rest_is_timed(mixed: str) -> None:
    assert "new: `ukwial:another:-`" in mixed
    assert "| `ukwial:pinv:-` |" in mixed


def test_a_users_own_method_is_gated_too_and_without_valgrind_the_gate_says_that_it_counts_no_instructions(
    mixed: str,
) -> None:
    assert "| `ukwial:mine:-` |" in mixed
    assert "valgrind is missing, install it" in mixed


def test_a_vehicle_whose_limits_changed_is_judged_by_its_own_numbers(repository: Path) -> None:
    def weaken(tree: Path) -> None:
        file = tree / "alloc" / "vehicles" / "ukwial.yaml"
        file.write_text(file.read_text().replace("f_max: 250", "f_max: 200"))

    result = gate(repository, weaken, cells=("--cells", "ukwial:nullspace"))
    assert "ukwial: its numbers differ, so each side is judged by its own" in result.stdout
    assert "| `ukwial:nullspace:-` |" in result.stdout
    assert "wrong" not in result.stdout


def test_a_vehicle_that_no_longer_loads_is_a_regression_and_not_bad_usage(repository: Path) -> None:
    def spoil(tree: Path) -> None:
        (tree / "alloc" / "vehicles" / "ukwial.yaml").write_text("name: ukwial\n")

    result = gate(repository, spoil)
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
    result = CliRunner().invoke(command, arguments, standalone_mode=False)
    assert says in str(result.exception)


def test_cell_patterns_that_fit_nothing_are_bad_usage(repository: Path) -> None:
    arguments = ["HEAD", "--repo", str(repository), "--always", "--cells", "ukwial:nix"]
    result = CliRunner().invoke(command, arguments, standalone_mode=False)
    assert "no cell of either side fits ukwial:nix" in str(result.exception)


PLUGIN = """\
import numpy as np

LIMITED = True


def build(vehicle):
    G = np.linalg.pinv(vehicle.TP)
    return lambda tau: np.clip(G @ tau, vehicle.f_min, vehicle.f_max)
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A repository of a user's own: a plug-in in a folder, no ``alloc``, one commit."""
    tree = tmp_path / "own"
    (tree / "control").mkdir(parents=True)
    (tree / "control" / "mine.py").write_text(PLUGIN)
    gate_check.git(tree, "init", "--quiet")
    gate_check.commit(tree, "base")
    return tree


def gate_own(own: Path, text: str, *options: str) -> Result:
    """What the gate says in the user's repository of a commit that gives the plug-in that text."""
    (own / "control" / "mine.py").write_text(text)
    (own / "notes.txt").write_text("so that there is something to commit")
    gate_check.commit(own, "head")
    few = ("--pairs", "2", "--no-instructions", "--vehicle", "ukwial", *options)
    plugin = ("--plugin", str(own / "control" / "mine.py"))
    return CliRunner().invoke(
        command, ["HEAD~1", "HEAD", "--repo", str(own), *plugin, *few], standalone_mode=False
    )


def test_a_user_s_plug_in_is_taken_from_each_side_of_the_user_s_repository(own: Path) -> None:
    """The working copy has the head's file only, so a difference shows that base has its own."""
    result = gate_own(own, PLUGIN.replace("G @ tau", "0.9 * G @ tau"))
    assert result.return_value == 1, result.output
    assert "| `ukwial:mine:-` | another answer: status SOLVED → PARTIAL" in result.stdout
    assert "pinv" not in result.stdout


def test_a_relative_path_is_the_repository_s_from_anywhere(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file of that name here, which no commit holds, would be compared with itself, and pass."""
    (tmp_path / "here" / "control").mkdir(parents=True)
    (tmp_path / "here" / "control" / "mine.py").write_text(PLUGIN)
    monkeypatch.chdir(tmp_path / "here")
    (own / "control" / "mine.py").unlink()
    gate_check.commit(own, "head")
    options = ("--repo", "../own", "--vehicle", "ukwial", "--no-instructions")
    result = CliRunner().invoke(command, ["HEAD~1", *options, "--plugin", "control/mine.py"])
    assert "| `ukwial:mine:-` | gone: head has no such method" in result.stdout


def test_a_file_that_a_plug_in_opens_is_each_side_s_own(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = PLUGIN.replace("G @ tau", "float(open('control/gain.txt').read()) * G @ tau")
    (own / "control" / "mine.py").write_text(text)
    (own / "control" / "gain.txt").write_text("1.0")
    gate_check.commit(own, "with a file")
    (own / "control" / "gain.txt").write_text("0.9")
    gate_check.commit(own, "another gain")
    monkeypatch.chdir(tmp_path)
    few = ["--pairs", "2", "--no-instructions", "--vehicle", "ukwial", "--plugin", "control/mine.py"]
    result = CliRunner().invoke(command, ["HEAD~1", "HEAD", "--repo", str(own), *few], standalone_mode=False)
    assert result.return_value == 1, result.output
    assert "| `ukwial:mine:-` | another answer: status SOLVED → PARTIAL" in result.stdout


def test_a_package_of_both_sides_that_is_installed_too_is_refused(own: Path, tmp_path: Path) -> None:
    """``pip install .`` of a repository with src: both sides ran the copy, and a wrong sign passed."""
    for folder in (own / "src" / "rov", tmp_path / "site" / "rov"):
        folder.mkdir(parents=True)
        (folder / "__init__.py").write_text("")
        (folder / "core.py").write_text("SIGN = 1")
    installed = f"import sys; sys.path.insert(0, {str(tmp_path / 'site')!r}); from rov.core import SIGN\n"
    text = installed + PLUGIN.replace("G @ tau", "SIGN * G @ tau")
    (own / "control" / "mine.py").write_text(text)
    gate_check.commit(own, "base")
    (own / "src" / "rov" / "core.py").write_text("SIGN = -1")
    result = gate_own(own, text)
    assert isinstance(result.exception, BadTree), result.output
    assert re.search(
        r"'rov.*' came from .*site/rov/.*, and not from the side's own src/rov/.*; uninstall it",
        str(result.exception),
    )


LATE = """
LIMITED = True
def build(vehicle):
    def allocate(tau):
        from gains import SIGN
        return np.clip(SIGN * np.linalg.pinv(vehicle.TP) @ tau, vehicle.f_min, vehicle.f_max)
    return allocate
"""


@pytest.mark.parametrize("late", [False, True])
def test_a_module_that_an_installation_takes_from_the_user_s_folder_is_refused(own: Path, late: bool) -> None:
    """Both sides would run the file as it lies there, and a wrong sign in it would pass."""
    (own / "src").mkdir()
    gains = own / "src" / "gains.py"
    gains.write_text("SIGN = 1")
    installed = f"import sys; sys.path.insert(0, {str(own / 'src')!r})\n"
    at_once = "from gains import SIGN\n" + PLUGIN.replace("G @ tau", "SIGN * G @ tau")
    text = installed + (f"import numpy as np\n{LATE}" if late else at_once)
    (own / "control" / "mine.py").write_text(text)
    gate_check.commit(own, "base")
    gains.write_text("SIGN = -1")
    result = gate_own(own, text)
    assert isinstance(result.exception, BadTree), result.output
    assert f"'gains' came from {gains}, as it lies there, and not from the side's own" in str(
        result.exception
    )


def test_a_plug_in_that_the_head_lost_is_gone(own: Path) -> None:
    (own / "control" / "mine.py").rename(own / "control" / "other.py")
    gate_check.commit(own, "head")
    options = ("--repo", str(own), "--plugin", str(own / "control" / "mine.py"), "--no-instructions")
    result = CliRunner().invoke(command, ["HEAD~1", "HEAD", *options], standalone_mode=False)
    assert result.return_value == 1, result.output
    assert "| `ukwial:mine:-` " in result.stdout
    assert "head has no such method, vehicle or start" in result.stdout


def test_what_is_not_committed_is_named_where_the_head_is_the_current_commit(own: Path) -> None:
    (own / "control" / "mine.py").write_text(PLUGIN.replace("G @ tau", "-G @ tau"))
    options = ("--repo", str(own), "--plugin", str(own / "control" / "mine.py"))
    result = CliRunner().invoke(command, ["HEAD", *options], standalone_mode=False)
    assert result.return_value == 0, result.output
    assert "- not committed, so not looked at: control/mine.py\n" in result.stdout


def test_a_commit_that_adds_a_plug_in_is_no_regression(own: Path) -> None:
    (own / "control" / "new.py").write_text(PLUGIN)
    gate_check.commit(own, "head")
    options = ("--repo", str(own), "--plugin", str(own / "control" / "new.py"), "--vehicle", "ukwial")
    result = CliRunner().invoke(command, ["HEAD~1", "HEAD", *options], standalone_mode=False)
    assert result.return_value == 3, result.output
    assert "nothing to compare: no cell stands on both sides" in result.stdout
    assert "new: `ukwial:new:-`" in result.stdout


@pytest.mark.parametrize("names", [("mine.py", "other/mine.py"), ("pinv.py",)])
def test_two_methods_of_one_name_are_refused(own: Path, names: tuple[str, ...]) -> None:
    """Else the one that is loaded first would have no row, and no word."""
    plugins = [word for name in names for word in ("--plugin", str(own / name))]
    result = CliRunner().invoke(command, ["HEAD", "--repo", str(own), *plugins], standalone_mode=False)
    assert f"another method is called '{Path(names[0]).stem}' too; rename the file" in str(result.exception)


def test_a_folder_that_a_commit_lacks_is_named(own: Path) -> None:
    (own / "later").mkdir()
    plugin = ("--plugin", str(own / "control" / "mine.py"))
    result = CliRunner().invoke(command, ["HEAD", "--repo", str(own / "later"), *plugin])
    assert isinstance(result.exception, BadTree)
    assert ":later/; give a revision that exists here" in str(result.exception)


@pytest.mark.parametrize("folder", [".", "own/control"])
def test_a_plug_in_that_nobody_committed_is_refused(own: Path, folder: str) -> None:
    """It would be compared with itself, and pass whatever it answers."""
    file = own.parent / folder / "new.py"
    file.write_text(PLUGIN)
    plugin = ("--plugin", str(file))
    result = CliRunner().invoke(command, ["HEAD", "--repo", str(own), *plugin], standalone_mode=False)
    assert "new.py: neither side holds it, so it would be compared with itself; commit it" in str(
        result.exception
    )


def test_a_plug_in_that_is_nowhere_is_not_to_be_committed(own: Path) -> None:
    plugin = ("--plugin", str(own / "control" / "misspelt.py"))
    result = CliRunner().invoke(command, ["HEAD", "--repo", str(own), *plugin], standalone_mode=False)
    assert "misspelt.py: is neither here nor in one of the two sides; give a plug-in's file" in str(
        result.exception
    )


def test_what_git_leaves_out_of_archives_and_what_a_link_points_to_is_gated(own: Path) -> None:
    (own / ".gitattributes").write_text("mine.py export-ignore\n")
    (own / "link.py").symlink_to("control/mine.py")
    gate_check.commit(own, "base")
    result = gate_own(own, PLUGIN.replace("G @ tau", "-G @ tau"), "--plugin", str(own / "link.py"))
    assert result.return_value == 1, result.output
    for name in ("mine", "link"):
        assert re.search(rf"^\| `ukwial:{name}:-` +\| (wrong|another) answer: ", result.stdout, re.M)


def test_a_repository_without_a_library_needs_a_plug_in(own: Path) -> None:
    result = CliRunner().invoke(command, ["HEAD", "HEAD", "--repo", str(own)], standalone_mode=False)
    assert "holds no package 'alloc'" in str(result.exception)


def test_a_pattern_that_fits_no_cell_is_named_among_others_that_do(repository: Path) -> None:
    result = gate(repository, lambda _: None, "--always", "--cells", "ukwial:pinvv")
    assert "no cell of either side fits ukwial:pinvv" in str(result.exception)
