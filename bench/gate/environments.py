"""Parts of a tree that influence a measurement, and the interpreter that runs it."""

import hashlib
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bench.gate.side import SourceTree
from bench.gate.trees import BASE, HEAD, BadTree


def influences(tree: Path, files: Sequence[Path] = ()) -> dict[str, str]:
    """Everything in a tree that can influence measured code: digests by file, and the requirements.

    That is ``alloc``, or every file but documents where one of users' ``files`` lies there, for it may
    import any.
    """
    everything = _holds(tree, files)
    return {
        path.relative_to(tree).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted((tree if everything else tree / "alloc").rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts and path.suffix != ".md"
    } | ({} if everything else {"requirements": "\n".join(requirements(tree))})


def _holds(tree: Path, files: Sequence[Path]) -> bool:
    return any(file.is_relative_to(tree) for file in files)


def requirements(tree: Path) -> list[str]:
    """Packages that a tree asks for: its dependencies, solvers included, and the pinned versions.

    Raises BadTree for a pyproject.toml that can't be read.
    """
    project = _project(tree)
    required = sorted(project.get("dependencies", []))
    required += sorted(project.get("optional-dependencies", {}).get("solvers", []))
    if (tree / "constraints.txt").is_file():
        lines = (tree / "constraints.txt").read_text(encoding="utf-8").splitlines()
        required += sorted(filter(None, (line.partition("#")[0].strip() for line in lines)))
    return required


def unchanged(base: SourceTree, head: SourceTree) -> str:
    """Reason why nothing needs to be measured; empty where something does."""
    of_base, of_head = (influences(side.path, side.plugins) for side in (base, head))
    if of_base != of_head:
        return ""
    everything = _holds(base.path, base.plugins)
    same = "all files but documents" if everything else "alloc/ and the requirements"
    return f"{same} are the same on both sides: nothing that differs can be measured"


def prepare(base: SourceTree, head: SourceTree, environments: Path) -> tuple[SourceTree, SourceTree]:
    """Both sides ready to run: compiled, each with an interpreter that has the tree's requirements."""
    ready = []
    pythons = interpreters(base.path, head.path, environments)
    for side, python in zip((base, head), pythons, strict=True):
        command = [python, "-m", "compileall", "-q", str(side.path / "alloc")]
        subprocess.run(command, capture_output=True, check=False)  # a syntax error shows when it is imported
        ready.append(side._replace(python=python))
    return ready[0], ready[1]


def interpreters(base: Path, head: Path, environments: Path) -> tuple[str, str]:
    """Each side's interpreter: the running one where requirements are equal, else one in an environment."""
    if requirements(base) == requirements(head):
        return sys.executable, sys.executable
    return _environment(base, environments / BASE), _environment(head, environments / HEAD)


def _environment(tree: Path, at: Path) -> str:
    dependencies = _project(tree).get("dependencies", [])
    if not dependencies:
        raise BadTree(
            f"{tree.name}: says in no pyproject.toml what it requires, and the other side does; add the file"
        )
    python = str(at / "bin" / "python")
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    if (tree / "constraints.txt").is_file():
        install += ["--constraint", str(tree / "constraints.txt")]
    for command in ([sys.executable, "-m", "venv", str(at)], [*install, *dependencies]):
        done = subprocess.run(command, capture_output=True, text=True, errors="replace")
        if done.returncode != 0:
            last = ((done.stderr or done.stdout).strip().splitlines() or ["no message"])[-1]
            raise BadTree(f"{tree.name}: its requirements can't be installed ({last}); mend pyproject.toml")
    return python


def _project(tree: Path) -> dict[str, Any]:
    # The table [project] of a tree's pyproject.toml, empty where there is none.
    file = tree / "pyproject.toml"
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    except ValueError as error:  # raised by TOML and by UTF-8
        raise BadTree(f"{tree.name}: pyproject.toml can't be read ({error}); mend it") from None
    return dict(document.get("project", {}))
