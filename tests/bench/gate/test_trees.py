"""A side is unpacked whole, submodules and neighbours, and gets an interpreter with what it requires."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import gate_check
from bench.gate import trees
from bench.gate.trees import SourceTree


def in_a_submodule(folder: Path) -> tuple[trees.Source, trees.Source]:
    """Two commits of a repository, between which its submodule alone changes."""
    for name in ("lib", "own"):
        (folder / name).mkdir()
        gate_check.git(folder / name, "init", "--quiet")
    (folder / "lib" / "gains.py").write_text("SIGN = 1")
    gate_check.commit(folder / "lib", "base")
    own = folder / "own"
    (own / "mine.py").write_text("from lib import gains")
    gate_check.git(own, "-c", "protocol.file.allow=always", "submodule", "--quiet", "add", "../lib", "lib")
    gate_check.commit(own, "base")
    (own / "lib" / "gains.py").write_text("SIGN = -1")
    gate_check.commit(own / "lib", "head")
    gate_check.commit(own, "head")
    return trees.revision(own, "HEAD~1"), trees.revision(own, "HEAD")


def in_two_folders(folder: Path, library: bool = False) -> tuple[trees.Source, trees.Source]:
    """Two folders, in which a file beside the plug-in alone is another; with a library or not."""
    sides = folder / "base side", folder / "head side"
    for sign, side in enumerate(sides):
        (side / "lib").mkdir(parents=True)
        (side / "lib" / "gains.py").write_text(f"SIGN = {sign}")
        (side / "mine.py").write_text("from lib import gains")
        (side / ".venv").mkdir()
        (side / ".venv" / "large.py").write_text(f"SIGN = {sign}")
        if library:
            (side / "alloc").mkdir()
            (side / "alloc" / "__init__.py").touch()
            (side / "alloc" / "allocation.py").touch()
    return trees.folder(sides[0]), trees.folder(sides[1])


def with_a_library(folder: Path) -> tuple[trees.Source, trees.Source]:
    return in_two_folders(folder, library=True)


@pytest.mark.parametrize("made", [in_a_submodule, in_two_folders, with_a_library])
def test_what_a_plug_in_imports_from_beside_it_is_each_side_s_own(
    tmp_path: Path, made: Callable[[Path], tuple[trees.Source, trees.Source]]
) -> None:
    """Else nothing differed, and the gate passed at once."""
    sides = made(tmp_path)
    both = []
    for source, name in zip(sides, ("base", "head"), strict=True):
        unpack = trees.own if trees.is_own(source) else trees.unpack
        unpack(source, tmp_path / name, ["mine.py"])
        both.append(SourceTree(tmp_path / name, plugins=(str(tmp_path / name / "mine.py"),)))
        assert not (tmp_path / name / ".venv").exists()
    base, head = ((tmp_path / name / "lib" / "gains.py").read_text() for name in ("base", "head"))
    assert base != head
    assert trees.unchanged(*both) == ""
    assert trees.unchanged(both[0], both[0]).startswith("all files but documents are the same")


def test_a_submodule_that_is_not_here_is_named(tmp_path: Path) -> None:
    base, _ = in_a_submodule(tmp_path)
    gate_check.git(base.path, "submodule", "--quiet", "deinit", "--force", "lib")
    with pytest.raises(trees.BadTree, match=r"lib: a submodule that is not here; run git submodule update"):
        trees.own(base, tmp_path / "base", [])


def test_a_package_of_the_user_s_that_is_called_alloc_is_named(tmp_path: Path) -> None:
    """It was taken for a tree of this project, and the remedy was another base."""
    base, _ = in_two_folders(tmp_path)
    (base.path / "alloc").mkdir()
    (base.path / "alloc" / "__init__.py").touch()
    assert trees.is_own(base)
    with pytest.raises(trees.BadTree, match="has an 'alloc' that is none of this project's; rename it"):
        trees.own(base, tmp_path / "base", ["mine.py"])


def test_requirements_hold_dependencies_and_pinned_versions_and_no_comments(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text(
        '[project]\ndependencies = ["numpy"]\n[tool.ruff]\nline-length = 1\n'
    )
    (tmp_path / "constraints.txt").write_text("# a comment\nnumpy==2.0 # another\n")
    assert trees.requirements(tmp_path) == ["numpy", "numpy==2.0"]


def requiring(folder: Path, **texts: str | None) -> list[Path]:
    """A tree for each name, with that text in its pyproject.toml, or none."""
    for name, text in texts.items():
        (folder / name / "alloc").mkdir(parents=True)
        if text is not None:
            (folder / name / "pyproject.toml").write_text(text)
    return [folder / name for name in (*texts, "environments")]


NUMPY = '[project]\ndependencies = ["numpy"]\n'


def test_trees_with_different_requirements_get_environments_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trees, "_environment", lambda tree, at: f"python of {tree.name} in {at.name}")
    base, head, at = requiring(tmp_path, base=NUMPY, head=NUMPY.replace("numpy", "numpy>=2"))
    assert trees.interpreters(base, head, at) == ("python of base in base", "python of head in head")
    assert trees.interpreters(base, base, at) == (sys.executable, sys.executable)


@pytest.mark.parametrize(
    ("text", "says"),
    [(None, "says in no pyproject.toml what it requires"), ("[project", "pyproject.toml can't be read")],
)
def test_a_tree_that_does_not_say_what_it_requires_is_named(
    text: str | None, says: str, tmp_path: Path
) -> None:
    base, head, at = requiring(tmp_path, base=NUMPY, head=text)
    with pytest.raises(trees.BadTree, match=f"^head: {says}"):
        trees.interpreters(head, base, at)
