"""A side is unpacked whole: submodules, the plug-in's neighbours, a user's own library."""

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
