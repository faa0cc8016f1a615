"""Self-check of the gate on small repositories with known changes: ``python -m bench.studies.gate_check``.

Each case is a commit on top of a copy of this tree. It takes about half a minute, too long for a
unit test; ``.ci/run`` runs it after the tests. Exit code 1 if a verdict is not the expected one.
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import monotonic
from typing import NamedTuple

from bench.gate.instructions import missing
from bench.gate.verdict import Outcome
from bench.studies.injection import CLOSED_FORMS, delete_method, scale_thrusts, slow_down, statement_ns

ROOT = Path(__file__).parents[2]
CALL_NS = 1000.0
"""About what a call of pinv takes; 15 % of it is the slow-down to be found."""


class GateCase(NamedTuple):
    """A change, how the gate is asked about it, and what it must answer."""

    name: str
    change: Callable[[Path], None]
    options: tuple[str, ...]
    exit_code: int
    says: str


def cases() -> list[GateCase]:
    """The gate's promises, each as a commit."""
    some = ("--cells", "ukwial:pinv", "--cells", "ukwial:qp/daqp:reused", "--cells", "ukwial:nullspace")
    tenths = round(0.15 * CALL_NS / statement_ns())
    return [
        GateCase("identical trees, measured", lambda _: None, ("--always", *some), 0, "pass: 3 cells"),
        GateCase(
            "15 % more work in a call",
            partial(slow_down, where=CLOSED_FORMS, statements=tenths),
            ("--cells", "ukwial:pinv", "--no-instructions"),
            1,
            "ukwial:pinv",
        ),
        GateCase("thrusts scaled by 1.001", partial(scale_thrusts, factor=1.001), (), 1, "wrong answer"),
        GateCase("a method deleted", partial(delete_method, name="svd"), (), 1, "ukwial:svd:-"),
        GateCase("README edited", partial(edit, name="README.md"), (), 0, "pass at once"),
    ]


def edit(tree: Path, name: str) -> None:
    """Change a file that can't influence what is measured."""
    (tree / name).write_text("Another sentence.\n", encoding="utf-8")


def copy(into: Path) -> None:
    """A repository with one commit: what can be measured of this tree."""
    into.mkdir()
    shutil.copytree(ROOT / "alloc", into / "alloc", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, into)
    git(into, "init", "--quiet")
    commit(into, "base")


def commit(tree: Path, message: str) -> None:
    """Commit everything, also nothing, as nobody in particular."""
    git(tree, "add", "--all")
    nobody = ("-c", "user.name=check", "-c", "user.email=check@localhost")
    git(tree, *nobody, "commit", "--quiet", "--allow-empty", "--message", message)


def git(tree: Path, *arguments: str) -> None:
    """Run git there; raises CalledProcessError."""
    subprocess.run(["git", *arguments], cwd=tree, check=True)


def main() -> int:
    """Run all cases, print a line each; 1 if any came out wrong."""
    failed = 0
    if missing():
        print(missing())
    for case in cases():
        with tempfile.TemporaryDirectory() as folder:
            tree = Path(folder) / "tree"
            copy(tree)
            case.change(tree)
            commit(tree, case.name)
            started = monotonic()
            gate = [sys.executable, "-m", "bench", "gate", "HEAD~1", "HEAD", "--repo", str(tree)]
            for _ in range(2):  # once more where the machine moved, as anybody would
                done = subprocess.run([*gate, *case.options], cwd=ROOT, capture_output=True, text=True)
                if done.returncode != Outcome.INCONCLUSIVE:
                    break
        good = done.returncode == case.exit_code and case.says in done.stdout
        failed += not good
        print(f"{'ok' if good else 'FAILED':6} {monotonic() - started:5.1f} s  {case.name}", flush=True)
        if not good:
            print(done.stdout, done.stderr, sep="\n")
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
