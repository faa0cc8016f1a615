"""Requirements of a tree, and the interpreter that it gets."""

import sys
from pathlib import Path

import pytest

from bench.gate import trees
from bench.gate.trees import BadTree


def test_requirements_hold_dependencies_and_pinned_versions_and_no_comments(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text(
        '[project]\ndependencies = ["numpy"]\n[tool.ruff]\nline-length = 1\n'
    )
    (tmp_path / "constraints.txt").write_text("# a comment\nnumpy==2.0 # another\n")
    assert trees.requirements(tmp_path) == ["numpy", "numpy==2.0"]


def test_trees_with_different_requirements_get_environments_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for side, dependency in (("base", "numpy"), ("head", "numpy>=2")):
        (tmp_path / side / "alloc").mkdir(parents=True)
        (tmp_path / side / "pyproject.toml").write_text(f'[project]\ndependencies = ["{dependency}"]\n')
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
    with pytest.raises(BadTree, match=f"^head: {says}"):
        trees.interpreters(head, base, tmp_path / "environments")
