"""Two trees in folders of equal path length, from commits or folders, each with its interpreter."""

import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import alloc
from alloc import AllocError
from alloc.discovery import plugin_name
from alloc.foreign import COMMAND, is_command, runs_apart

COMPILED = shutil.ignore_patterns("__pycache__", "*.pyc")
"""Files of a package that are not copied."""
SUBMODULE = re.compile(r"160000 commit (?P<commit>[0-9a-f]+)\t(?P<path>.+)")
"""A line of git ls-tree that names another repository's commit."""
TREE = "alloc/allocation.py"
"""A file that every tree of this project has, and a user's own package of that name hardly."""
PLACES = (
    "GIT_DIR",
    "GIT_COMMON_DIR",
    "GIT_WORK_TREE",
    "GIT_IMPLICIT_WORK_TREE",
    "GIT_INDEX_FILE",
    "GIT_PREFIX",
    "GIT_QUARANTINE_PATH",
)
"""Variables by which git tells a hook its repository, and which git would believe in any other folder.

Others of ``git rev-parse --local-env-vars`` stay: a hook of a push finds the commits by GIT_OBJECT_DIRECTORY,
and GIT_CONFIG_COUNT may say which folders are safe. In quarantine, until a hook of a push has agreed, git
would refuse a work tree.
"""
OURS = ("-c", "core.hooksPath=/dev/null", "-c", "core.sparseCheckout=false")
"""Settings of git under which a work tree is whole, and no hook of the user's runs in it."""
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
    start : within it, the folder that the user named
    """

    label: str
    path: Path
    commit: str = ""
    start: Path = Path()


BUILD_S = 600.0
"""Longest time that building a side's plug-ins may take [s]."""


class SourceTree(NamedTuple):
    """One side, ready to run.

    Attributes
    ----------
    path : the folder that holds ``alloc``
    python : the interpreter that runs it
    plugins : files with users' own methods, as this side has them, and commands
    vehicles : files of users' own vehicles, by what their cells are called; the same on both sides
    source : the user's folder that the tree is a copy of; None where it is none
    start : within ``path``, the folder in which its processes run
    """

    path: Path
    python: str = sys.executable
    plugins: tuple[str, ...] = ()
    vehicles: Mapping[str, str] = MappingProxyType({})
    source: Path | None = None
    start: Path = Path()

    @property
    def apart(self) -> list[str]:
        """Methods of ``plugins`` that other processes answer."""
        return [plugin_name(plugin) for plugin in self.plugins if runs_apart(plugin)]


def revision(repository: Path, name: str) -> Source:
    """A git revision; its label is the name with the commit it stands for. Raises BadTree.

    Of a folder within a repository it is all of that, since a plug-in there may import any of it, unless the
    folder holds ``alloc``.
    """
    commit = _git(repository, "rev-parse", "--verify", f"{name}^{{commit}}")
    source = Source(f"{name} ({commit[:10]})", repository, commit)
    up = _git(repository, "rev-parse", "--show-cdup")  # ../ for each folder, nothing in a bare repository
    if not up or not is_own(source):
        return source
    return source._replace(path=repository / up, start=Path(_git(repository, "rev-parse", "--show-prefix")))


def folder(path: Path) -> Source:
    """A folder that holds a tree, with ``alloc`` in it."""
    return Source(str(path), path)


def is_own(source: Source) -> bool:
    """True if a side lacks this project's ``alloc``: a user's repository, whose plug-ins are measured."""
    if not source.commit:
        return not (source.path / TREE).is_file()
    return _run(source.path, "cat-file", "-e", f"{source.commit}:./{TREE}").returncode != 0


def own(source: Source, into: Path, plugins: Sequence[str]) -> None:
    """Put a user's files and the installed ``alloc`` into the new folder ``into``; raises BadTree."""
    if source.commit:
        _extract(source, into)
    else:
        _copy(source, into, plugins)
    if (into / "alloc").exists():
        raise BadTree(f"{source.label}: has an 'alloc' that is none of this project's; rename it")
    shutil.copytree(Path(alloc.__file__).parent, into / "alloc", ignore=COMPILED)


def build(label: str, tree: Path, command: str) -> None:
    """Run the command that builds a side's plug-ins in its tree; raises BadTree where it fails."""
    try:
        done = subprocess.run(
            shlex.split(command), cwd=tree, capture_output=True, text=True, errors="replace", timeout=BUILD_S
        )
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()
        why = f"exit code {done.returncode}: {said[-1] if said else 'no message'}" if done.returncode else ""
    except subprocess.TimeoutExpired:
        why = f"ran for longer than {BUILD_S:g} s"
    except (OSError, ValueError) as error:
        why = str(error)
    if why:
        raise BadTree(f"{label}: --build {command!r} failed ({why}); mend it, or the tree")


def find_plugins(
    sides: Sequence[tuple[Source, Path]], plugins: Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Users' files as base and head have them, or as they lie where neither side holds them.

    ``sides`` are each side's source and the folder that it is unpacked in. A file that only one side holds is
    left out of the other. A command is the same on both sides: each runs it in its own folder. Raises BadTree
    for a file that is nowhere, and for what both sides would have the same.
    """
    found: tuple[list[str], list[str]] = [], []
    trees = [tree for _, tree in sides]
    users = all(is_own(source) for source, _ in sides)
    for name in plugins:
        if is_command(name):
            if users and not any(_names_a_file(name, tree / source.start) for source, tree in sides):
                raise BadTree(f"{name}: names no file of a side, so it would be compared with itself")
            for mine in found:
                mine.append(name)
            continue
        file = Path(name)
        places = [place for source, _ in sides for place in _inside(source, file)]
        within = next((each for each in places if any((tree / each).is_file() for tree in trees)), None)
        if within is not None:
            for mine, tree in zip(found, trees, strict=True):
                mine += [str(tree / within)] if (tree / within).is_file() else []
        elif not file.is_file():
            raise BadTree(f"{file}: is neither here nor in one of the two sides; give a plug-in's file")
        elif users:
            raise BadTree(f"{file}: neither side holds it, so it would be compared with itself; commit it")
        else:
            for mine in found:
                mine.append(str(file.absolute()))
    return tuple(found[0]), tuple(found[1])


def _names_a_file(command: str, folder: Path) -> bool:
    """True if a word of a command is a file of a folder."""
    words = re.split(r"[\s'\";]+", command.removeprefix(COMMAND))
    return any((folder / word).is_file() for word in words if not Path(word).is_absolute())


def _inside(source: Source, file: Path) -> list[Path]:
    """Path of a file inside a side, None for one elsewhere; a relative path may start from the side."""
    # The file itself may be a link; it is what the user named.
    here, side = file.parent.resolve() / file.name, source.path.resolve()
    found = []
    if here.is_relative_to(side) and (source.commit or file.is_absolute()):
        found.append(here.relative_to(side))
    if not file.is_absolute() and ".." not in file.parts:
        found.append(source.start / file)
    return found


def _extract(source: Source, into: Path) -> None:
    """Put a commit's files, those of its submodules too, into the new folder ``into``."""
    prefix = _git(source.path, "rev-parse", "--show-prefix")
    whole = into.with_name(f"{into.name}-tree") if prefix else into
    # The work tree is git's no longer once it is there, so that nothing of it stays in the user's repository.
    _git(source.path, *OURS, "worktree", "add", "--quiet", "--force", "--detach", str(whole), source.commit)
    (whole / ".git").unlink()
    _git(source.path, "worktree", "prune")
    if prefix:
        (whole / prefix).rename(into)
        shutil.rmtree(whole)
    for entry in _git(source.path, "ls-tree", "-r", "-z", f"{source.commit}:{prefix}").split("\0"):
        if found := SUBMODULE.fullmatch(entry):
            inner = source.path / found["path"]
            if not (inner / ".git").exists():
                raise BadTree(f"{inner}: a submodule that is not here; run git submodule update --init")
            _extract(Source(source.label, inner, found["commit"]), into / found["path"])


def _copy(source: Source, into: Path, plugins: Sequence[str]) -> None:
    """Put a folder that holds one of ``plugins`` into the new folder ``into``: it may read any file there."""
    into.mkdir(parents=True)
    if not any(_lies_in(source, name) for name in plugins):
        return
    try:
        shutil.copytree(
            source.path, into, ignore=_list_unread, ignore_dangling_symlinks=True, dirs_exist_ok=True
        )
    except (OSError, shutil.Error) as error:
        raise BadTree(
            f"{source.label}: can't be copied ({str(error)[:200]}); give a folder that can"
        ) from None


def _lies_in(source: Source, plugin: str) -> bool:
    """True if a folder holds a plug-in's file, or one that a command names."""
    if is_command(plugin):
        return _names_a_file(plugin, source.path)
    return any((source.path / within).is_file() for within in _inside(source, Path(plugin)))


def _list_unread(folder: str, names: list[str]) -> set[str]:
    """Names in a folder that no plug-in imports: hidden folders, environments, compiled files."""
    return {
        name
        for name in names
        if name == "__pycache__"
        or (name.startswith(".") and Path(folder, name).is_dir())
        or Path(folder, name, "pyvenv.cfg").exists()
    }


def unpack(source: Source, into: Path, plugins: Sequence[str] = ()) -> None:
    """Put ``alloc``, what it requires and users' ``plugins`` into the new folder ``into``; raises BadTree."""
    if source.commit:
        _extract(source, into)
    elif (source.path / "alloc").is_dir():
        _copy(source, into, plugins)
        shutil.copytree(source.path / "alloc", into / "alloc", ignore=COMPILED, dirs_exist_ok=True)
        for name in ("pyproject.toml", "constraints.txt"):
            if (source.path / name).is_file():
                shutil.copy(source.path / name, into / name)
    if not (into / "alloc" / "__init__.py").is_file():
        raise BadTree(f"{source.label}: holds no package 'alloc'; give the root of a tree that has it")


def commits(base: Source, head: Source) -> list[str]:
    """One line for each commit that head has and base has not, newest first; none between folders."""
    if not (base.commit and head.commit):
        return []
    span = f"{base.commit}..{head.commit}"
    return _git(head.path, "log", "--oneline", "--no-decorate", span).splitlines()


def uncommitted(head: Source) -> list[str]:
    """Files that lie in the repository otherwise than in the commit, where the head is the current commit."""
    if not head.commit or _git(head.path, "rev-parse", "HEAD") != head.commit:
        return []
    try:
        return _git(head.path, "diff", "--name-only", "--relative", "HEAD").splitlines()
    except BadTree:  # a bare repository has no files
        return []


def differs(base: Source, head: Source, file: Path) -> bool:
    """True if two commits differ in a file of their repository; never for a file elsewhere."""
    here = head.path.resolve()
    if not (base.commit and head.commit and file.is_relative_to(here)):
        return False
    between = ("diff-tree", "-r", "--name-only", base.commit, head.commit, "--")
    return bool(_git(head.path, "--literal-pathspecs", *between, str(file.relative_to(here))))


def _git(repository: Path, *arguments: str) -> str:
    done = _run(repository, *arguments)
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["unknown revision"])[0]
        raise BadTree(f"{repository}: git {' '.join(arguments)}: {reason}; give a revision that exists here")
    return done.stdout.strip()


def _run(repository: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run git in that folder, whatever repository's hook this is."""
    own = {name: value for name, value in os.environ.items() if name not in PLACES}
    try:
        return subprocess.run(["git", *arguments], cwd=repository, capture_output=True, text=True, env=own)
    except FileNotFoundError:
        raise BadTree("git is not installed; install it, or use --base-path and --head-path") from None


def digest(tree: Path, plugins: Sequence[str] = ()) -> dict[str, str]:
    """Everything in a tree that can influence measured code: digests by file, and the requirements.

    That is ``alloc``, or every file but documents where one of users' ``plugins`` lies there, for it may
    import any.
    """
    everything = _holds(tree, plugins)
    return {
        path.relative_to(tree).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted((tree if everything else tree / "alloc").rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts and path.suffix != ".md"
    } | ({} if everything else {"requirements": "\n".join(requirements(tree))})


def _holds(tree: Path, plugins: Sequence[str]) -> bool:
    return any(is_command(name) or Path(name).is_relative_to(tree) for name in plugins)


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
    of_base, of_head = (digest(side.path, side.plugins) for side in (base, head))
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
