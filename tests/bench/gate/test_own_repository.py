"""The gate on a user's own repository: each side gets the plug-in as its commit has it, and nothing else."""

import re
from pathlib import Path

import pytest
from click.testing import Result

import gate_check
from tests.gate_sides import PLUGIN, pip_notes, refusal, run_gate

pytestmark = pytest.mark.usefixtures("few_demands")

FEW = ("--pairs", "2", "--no-instructions", "--vehicle", "ukwial")


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
    """Verdict of the gate in the user's repository on a commit that gives the plug-in that text."""
    (own / "control" / "mine.py").write_text(text)
    (own / "notes.txt").write_text("so that there is something to commit")
    gate_check.commit(own, "head")
    return gate_at(own, "HEAD~1", "HEAD", own / "control" / "mine.py", *options)


def gate_at(own: Path, *revisions_and_options: object) -> Result:
    """Verdict of the gate in the user's repository; each path is a plug-in's."""
    words = [("--plugin", each) if isinstance(each, Path) else (each,) for each in revisions_and_options]
    return run_gate(*(word for each in words for word in each), "--repo", own, *FEW)


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
    result = run_gate("HEAD~1", "--repo", "../own", "--plugin", "control/mine.py", *FEW)
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
    result = gate_at(own, "HEAD~1", "HEAD", Path("control/mine.py"))
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
    says = r"'rov.*' came from .*site/rov/.*, and not from the side's own src/rov/.*; uninstall it"
    assert re.search(says, refusal(result))


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
    says = f"'gains' came from {gains}, as it lies there, and not from the side's own"
    assert says in refusal(gate_own(own, text))


@pytest.mark.parametrize("known", [True, False])
def test_what_was_built_from_the_user_s_folder_and_installed_is_refused(
    own: Path, tmp_path: Path, known: bool
) -> None:
    """A module in C++ has no file of its name in a commit: pip notes whence it was installed (PEP 610)."""
    site = tmp_path / "site"
    url = own.as_uri() if known else "https://example.org/gains.whl"
    pip_notes(site, "gains", url, files="gains.py,,\ngains-1.0.dist-info/METADATA,,\n")
    (site / "gains.py").write_text("SIGN = 1")
    installed = f"import sys; sys.path.insert(0, {str(site)!r}); from gains import SIGN\n"
    result = gate_own(own, installed + PLUGIN.replace("G @ tau", "SIGN * G @ tau"))
    if known:
        assert f"'gains' came from {site / 'gains.py'}, as it lies there" in refusal(result)
    else:
        assert "`ukwial:mine:-`" in result.stdout  # it was measured


def test_a_module_of_the_user_s_folder_that_no_commit_holds_is_refused(own: Path) -> None:
    (own / "build").mkdir()
    (own / "build" / "gains.py").write_text("SIGN = 1")
    (own / ".gitignore").write_text("build\n")
    built = f"import sys; sys.path.insert(0, {str(own / 'build')!r}); from gains import SIGN\n"
    error = refusal(gate_own(own, built + PLUGIN.replace("G @ tau", "SIGN * G @ tau")))
    assert "build/gains.py, as it lies there, and not from a commit; uninstall it" in error


def test_what_is_not_committed_is_named_where_the_head_is_the_current_commit(own: Path) -> None:
    (own / "control" / "mine.py").write_text(PLUGIN.replace("G @ tau", "-G @ tau"))
    result = gate_at(own, "HEAD", own / "control" / "mine.py")
    assert result.return_value == 0, result.output
    assert "- not committed, so not looked at: control/mine.py\n" in result.stdout


@pytest.mark.parametrize("changed", [True, False])
def test_a_vehicle_that_differs_between_the_sides_is_named(
    own: Path, monkeypatch: pytest.MonkeyPatch, changed: bool
) -> None:
    """Both sides are asked with the file as it lies here, and nothing said so."""
    text = (gate_check.ROOT / "alloc" / "vehicles" / "ukwial.yaml").read_text()
    (own / "my[rov].yaml").write_text(text)
    gate_check.commit(own, "base")
    if changed:
        (own / "my[rov].yaml").write_text(text.replace("f_max: 250", "f_max: 200"))
    monkeypatch.chdir(own)
    result = gate_own(own, PLUGIN, "--vehicle", "my[rov].yaml")
    assert result.exception is None, result.exception
    said = "- my[rov].yaml differs between the two sides; both were asked with it as it lies here"
    assert (said in result.stdout.replace("\\", "")) == changed, result.output


@pytest.mark.parametrize(
    ("files", "says"),
    [
        # The one that is loaded first would have no row, and no word.
        (["mine.py", "other/mine.py"], "another method is called 'mine' too; rename the file"),
        (["pinv.py"], "another method is called 'pinv' too; rename the file"),
        # It would be compared with itself, and pass whatever it answers.
        (["../new.py"], "new.py: neither side holds it, so it would be compared with itself; commit it"),
        (["control/new.py"], "new.py: neither side holds it, so it would be compared with itself; commit it"),
        (["control/misspelt.py"], "is neither here nor in one of the two sides; give a plug-in's file"),
        ([], "holds no package 'alloc'"),
    ],
)
def test_plug_ins_that_can_t_be_compared_are_refused(own: Path, files: list[str], says: str) -> None:
    for folder in (own.parent, own / "control"):
        (folder / "new.py").write_text(PLUGIN)
    assert says in str(gate_at(own, "HEAD", *(own / name for name in files)).exception)


def test_what_git_leaves_out_of_archives_and_what_a_link_points_to_is_gated(own: Path) -> None:
    (own / ".gitattributes").write_text("mine.py export-ignore\n")
    (own / "link.py").symlink_to("control/mine.py")
    gate_check.commit(own, "base")
    result = gate_own(own, PLUGIN.replace("G @ tau", "-G @ tau"), "--plugin", str(own / "link.py"))
    assert result.return_value == 1, result.output
    for name in ("mine", "link"):
        assert re.search(rf"^\| `ukwial:{name}:-` +\| (wrong|another) answer: ", result.stdout, re.M)
