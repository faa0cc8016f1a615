"""The gate in a folder of a user's repository: what a plug-in takes from beside it is a side's, too."""

import shutil
from pathlib import Path

import pytest
from click.testing import Result

import gate_check
from tests.gate_sides import pip_notes, refusal, run_gate

pytestmark = pytest.mark.usefixtures("few_demands")

ALWAYS = ("--pairs", "2", "--no-instructions", "--vehicle", "ukwial")

PLUGIN = """\
from pathlib import Path
import sys

sys.path.insert(0, {folder})
import numpy as np
from rovlib import inverse

LIMITED = True


def build(vehicle):
    G = inverse(vehicle.TP)
    return lambda tau: np.clip(G @ tau, vehicle.f_min, vehicle.f_max)
"""
RIGHT = "import numpy as np\n\n\ndef inverse(TP):\n    return np.linalg.pinv(TP)\n"
BESIDE = "str(Path(__file__).resolve().parents[1])"


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A plug-in in one folder and its helper in another, which the second of two commits makes wrong."""
    tree = tmp_path / "own"
    (tree / "control").mkdir(parents=True)
    (tree / "rovlib").mkdir()
    (tree / "control" / "mine.py").write_text(PLUGIN.format(folder=BESIDE))
    (tree / "rovlib" / "__init__.py").write_text(RIGHT)
    gate_check.git(tree, "init", "--quiet")
    gate_check.commit(tree, "base")
    (tree / "rovlib" / "__init__.py").write_text(RIGHT.replace("return np", "return -np"))
    gate_check.commit(tree, "sign")
    return tree


def gate(*arguments: object) -> Result:
    return run_gate(*arguments, *ALWAYS)


@pytest.mark.parametrize(
    ("here", "given"),
    [
        ("control", ["--plugin", "mine.py"]),
        ("control", ["--plugin", "mine.py", "--repo", "../rovlib"]),
        (".", ["--repo", "control", "--plugin", "mine.py"]),
        ("..", ["--repo", "own/control", "--plugin", "own/control/mine.py"]),
    ],
)
def test_a_wrong_helper_beside_the_folder_is_found(
    own: Path, monkeypatch: pytest.MonkeyPatch, here: str, given: list[str]
) -> None:
    """The folder's own files are the same on both sides, so it passed at once."""
    monkeypatch.chdir(own / here)
    result = gate("HEAD~1", "HEAD", *given)
    assert result.return_value == 1, result.output
    assert "`ukwial:mine:-`" in result.stdout


@pytest.mark.parametrize(
    "given",
    [
        {"GIT_DIR": ".git"},
        {"GIT_DIR": ".git", "GIT_WORK_TREE": ".", "GIT_PREFIX": ""},
        {"GIT_INDEX_FILE": ".git/next-index.lock", "GIT_PREFIX": "control/"},
    ],
)
def test_what_git_tells_a_hook_of_its_repository_changes_nothing(
    own: Path, monkeypatch: pytest.MonkeyPatch, given: dict[str, str]
) -> None:
    """A committed plug-in was to be committed, for git took that folder for the repository's root."""
    for name, value in given.items():
        monkeypatch.setenv(name, value if name == "GIT_PREFIX" else str(own / value))
    monkeypatch.chdir(own / "control")
    result = gate("HEAD~1", "HEAD", "--plugin", "mine.py")
    assert result.exception is None, result.exception
    assert result.return_value == 1, result.output
    assert "not committed" not in result.stdout


def test_a_helper_of_the_repository_that_is_installed_in_place_is_refused(
    own: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``pip install -e .`` puts the repository itself on the path: both sides would run what lies there."""
    (own / "control" / "mine.py").write_text(PLUGIN.format(folder=repr(str(own))))
    gate_check.commit(own, "installed")
    monkeypatch.chdir(own / "control")
    assert "'rovlib' came from" in refusal(gate("HEAD~1", "HEAD", "--plugin", "mine.py"))


def test_two_folders_whose_plug_ins_read_outside_of_them_are_not_passed_at_once(
    own: Path, tmp_path: Path
) -> None:
    other = shutil.copytree(own, tmp_path / "other")
    (other / "rovlib" / "__init__.py").write_text(RIGHT)
    sides = ("--base-path", other / "control", "--head-path", own / "control")
    result = gate(*sides, "--plugin", own / "control" / "mine.py", "--plugin", other / "control" / "mine.py")
    assert result.return_value != 0 or result.exception, result.output


@pytest.mark.parametrize("editable", [True, False])
def test_a_folder_s_helper_from_an_installation_around_it_is_refused(
    own: Path, tmp_path: Path, editable: bool
) -> None:
    """For an install with -e, pip notes the repository (PEP 610) and not its modules."""
    site = tmp_path / "site"
    pip_notes(site, "rov", own.as_uri(), editable=editable)
    text = PLUGIN.format(folder=repr(str(own)) + f"); sys.path.append({str(site)!r}")
    (own / "control" / "mine.py").write_text(text)
    other = shutil.copytree(own / "control", tmp_path / "control")
    (other / "note.txt").write_text("differs")
    sides = ("--base-path", other, "--head-path", own / "control")
    assert refusal(gate(*sides, "--plugin", own / "control" / "mine.py"))
