"""Self-check of the gate on small repositories with known changes: ``python docs/studies/gate_check.py``.

Each case is a commit on top of a copy of this tree. The check takes about half a minute, too long for a
unit test; ``.ci/run`` runs it after the tests. It exits with 1 if a verdict is not the expected one.
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from time import monotonic
from typing import NamedTuple

from bench.gate.run import missing
from bench.gate.verdict import Outcome
from injection import CLOSED_FORMS, delete_method, scale_thrusts, slow_down, statement_ns

ROOT = Path(__file__).parents[2]
CALL_NS = 1000.0
"""About the time of a call of pinv; the gate must find a slow-down by 15 % of it."""


class GateCase(NamedTuple):
    """A change, and what the gate must say of it.

    Attributes
    ----------
    name : what is changed
    change : makes the change in a tree
    options : of ``thrustbench gate``
    exit_code : the expected one
    says : what must be part of the report
    timed : whether the verdict hangs on times, so that nothing else may run meanwhile
    """

    name: str
    change: Callable[[Path], None]
    options: tuple[str, ...]
    exit_code: int
    says: str
    timed: bool = False


def cases() -> list[GateCase]:
    """The gate's promises, each as a commit."""
    few_cells = ("--cells", "ukwial:pinv", "--cells", "ukwial:qp/daqp:reused", "--cells", "ukwial:nullspace")
    statements = round(0.15 * CALL_NS / statement_ns())
    return [
        GateCase(
            name="identical trees, measured",
            change=lambda _: None,
            options=("--always", *few_cells),
            exit_code=0,
            says="pass: 3 cells",
            timed=True,
        ),
        GateCase(
            name="15 % more work in a call",
            change=partial(slow_down, where=CLOSED_FORMS, statements=statements),
            options=("--cells", "ukwial:pinv", "--no-instructions"),
            exit_code=1,
            says="ukwial:pinv",
            timed=True,
        ),
        GateCase(
            name="thrusts scaled by 1.001",
            change=partial(scale_thrusts, factor=1.001),
            options=(),
            exit_code=1,
            says="wrong answer",
        ),
        GateCase(
            name="a method deleted",
            change=partial(delete_method, name="svd"),
            options=(),
            exit_code=1,
            says="ukwial:svd:-",
        ),
        GateCase(
            name="README edited",
            change=partial(edit, name="README.md"),
            options=(),
            exit_code=0,
            says="pass at once",
        ),
    ]


def edit(tree: Path, name: str) -> None:
    """Change a file that can't influence what is measured."""
    (tree / name).write_text("Another sentence.\n", encoding="utf-8")


def copy(into: Path) -> None:
    """Make a repository with one commit: the part of this tree that the gate measures."""
    into.mkdir()
    shutil.copytree(ROOT / "alloc", into / "alloc", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, into)
    git(into, "init", "--quiet")
    commit(into, "base")


def commit(tree: Path, message: str) -> None:
    """Commit all changes, or none."""
    git(tree, "add", "--all")
    git(tree, "commit", "--quiet", "--allow-empty", "--message", message)


def git(tree: Path, *arguments: str) -> str:
    """Output of git there, under a made-up name; raises CalledProcessError."""
    # Users sign their commits and have hooks for all repositories: neither is for one that is thrown away.
    who = ("user.name=check", "user.email=check@localhost")
    settings = (*who, "commit.gpgsign=false", "core.hooksPath=/dev/null")
    command = ["git", *(word for setting in settings for word in ("-c", setting)), *arguments]
    return subprocess.run(command, cwd=tree, check=True, capture_output=True, text=True).stdout.strip()


def passes(case: GateCase) -> bool:
    """True if the gate's verdict is right; prints a line, and the gate's text where it is not."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        copy(tree)
        case.change(tree)
        commit(tree, case.name)
        started = monotonic()
        gate = [sys.executable, "-m", "bench", "gate", "HEAD~1", "HEAD", "--repo", str(tree)]
        for _ in range(2):  # an inconclusive gate is run once more, as a user would
            done = subprocess.run([*gate, *case.options], cwd=ROOT, capture_output=True, text=True)
            if done.returncode != Outcome.INCONCLUSIVE:
                break
    good = done.returncode == case.exit_code and case.says in done.stdout
    print(f"{'ok' if good else 'FAILED':6} {monotonic() - started:5.1f} s  {case.name}", flush=True)
    if not good:
        print(done.stdout, done.stderr, sep="\n")
    return good


def main() -> int:
    """Run all cases, those that time nothing two at once; 1 if any came out wrong."""
    if missing():
        print(missing())
    timed, others = (tuple(case for case in cases() if case.timed is kind) for kind in (True, False))
    good = [passes(case) for case in timed]
    with ThreadPoolExecutor(2) as side_by_side:
        good += side_by_side.map(passes, others)
    return int(not all(good))


if __name__ == "__main__":
    sys.exit(main())
