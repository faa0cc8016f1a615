"""Two trees in folders of equal path length, what differs between them, and which interpreter runs each."""

import hashlib
import io
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZipFile

from alloc import AllocError
from bench.gate.side import SourceTree

BASE, HEAD = "base", "head"
"""The folders' names: equally long, because a path's length shifts a process's memory layout."""


class BadTree(AllocError):
    """A revision or a folder can't be measured; the message says why and what to give instead."""


class Source(NamedTuple):
    """One side before it is prepared.

    Attributes
    ----------
    label : what the report calls it
    path : a repository, or a folder that holds a tree
    commit : the commit of the repository to take, empty for the folder as it is
    """

    label: str
    path: Path
    commit: str = ""


def revision(repository: Path, name: str) -> Source:
    """A git revision; its label is the name with the commit it stands for. Raises BadTree."""
    commit = _git(repository, "rev-parse", "--verify", f"{name}^{{commit}}")
    return Source(f"{name} ({commit[:10]})", repository, commit)


def folder(path: Path) -> Source:
    """A folder that holds a tree, with ``alloc`` in it."""
    return Source(str(path), path)


def unpack(source: Source, into: Path) -> None:
    """Put ``alloc`` and what it requires into the new folder ``into``; raises BadTree."""
    into.mkdir(parents=True)
    if source.commit:
        # The archive is a zip, because Debian 12's Python 3.11.2 knows no safe way to unpack a tar.
        command = ["git", "archive", "--format=zip", source.commit]
        packed = subprocess.run(command, cwd=source.path, capture_output=True, check=True)
        with ZipFile(io.BytesIO(packed.stdout)) as archive:
            archive.extractall(into)
    elif (source.path / "alloc").is_dir():
        skip = shutil.ignore_patterns("__pycache__", "*.pyc")
        shutil.copytree(source.path / "alloc", into / "alloc", ignore=skip)
        for name in ("pyproject.toml", "constraints.txt"):
            if (source.path / name).is_file():
                shutil.copy(source.path / name, into)
    if not (into / "alloc" / "__init__.py").is_file():
        raise BadTree(f"{source.label}: holds no package 'alloc'; give the root of a tree that has it")


def commits(base: Source, head: Source) -> list[str]:
    """One line for each commit that head has and base has not, newest first; none between folders."""
    if not (base.commit and head.commit):
        return []
    span = f"{base.commit}..{head.commit}"
    return _git(head.path, "log", "--oneline", "--no-decorate", span).splitlines()


def influences(tree: Path) -> dict[str, str]:
    """Everything in a tree that can influence measured code: digests by file, and the requirements."""
    digests = {
        str(path.relative_to(tree)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted((tree / "alloc").rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts and path.suffix != ".md"
    }
    return digests | {"requirements": "\n".join(requirements(tree))}


def requirements(tree: Path) -> list[str]:
    """What a tree asks to be installed: its dependencies, solvers included, and the pinned versions.

    Raises BadTree for a pyproject.toml that can't be read.
    """
    project = _project(tree)
    required = sorted(project.get("dependencies", []))
    required += sorted(project.get("optional-dependencies", {}).get("solvers", []))
    if (tree / "constraints.txt").is_file():
        pins = (tree / "constraints.txt").read_text(encoding="utf-8").splitlines()
        required += sorted(pin.strip() for pin in pins if pin.strip() and not pin.lstrip().startswith("#"))
    return required


def unchanged(base: Path, head: Path) -> str:
    """Why nothing needs to be measured; empty where something does."""
    if influences(base) != influences(head):
        return ""
    return "alloc/ and the requirements are the same on both sides: nothing that differs can be measured"


def prepare(
    base: Path, head: Path, environments: Path, plugins: tuple[Path, ...]
) -> tuple[SourceTree, SourceTree]:
    """Both sides ready to run: compiled, each with an interpreter that has the tree's requirements."""
    ready = []
    for path, python in zip((base, head), interpreters(base, head, environments), strict=True):
        command = [python, "-m", "compileall", "-q", str(path / "alloc")]
        subprocess.run(command, capture_output=True, check=False)  # a syntax error shows when it is imported
        ready.append(SourceTree(path, python, plugins))
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


def _git(repository: Path, *arguments: str) -> str:
    try:
        done = subprocess.run(["git", *arguments], cwd=repository, capture_output=True, text=True)
    except FileNotFoundError:
        raise BadTree("git is not installed; install it, or use --base-path and --head-path") from None
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["unknown revision"])[0]
        raise BadTree(f"{repository}: git {' '.join(arguments)}: {reason}; give a revision that exists here")
    return done.stdout.strip()
