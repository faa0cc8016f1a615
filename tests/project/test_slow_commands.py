"""The commands of the pages that ``test_typed_commands`` only parses are run here, each with less to do."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import bench.__main__
import gate_check
from alloc.c import missing
from tests.clusters import loopback_cluster
from tests.emulators import available
from tests.pages import saved
from tests.places import ROOT
from tests.project.test_typed_commands import GIVEN, LONG, PAGES, SHORT, commands

pytestmark = [pytest.mark.long, pytest.mark.skipif(bool(missing()), reason=missing() or "-")]

SMALL = {
    "run": SHORT,
    "gate": ("--pairs=2", "--threshold=900", "--no-instructions"),
    "emulate": ("--n=2", "--demands=inactive", "--method=pinv@native"),
    "board": ("--n=2", "--method=nullspace@native"),
    "layouts": ("--n=64", "--workers=1"),
    "fleet": SHORT,
    "pytest": ("--vehicle=ukwial", "--method=pinv", "--benchmark-max-time=0.001", "--benchmark-warmup=off"),
}
"""What a command is told beside what the page says, so that it takes seconds."""
ELSEWHERE = {
    "prove": "`.ci/run` proves the same kernel",
    "qp/slsqp": "needs a file in the tree; tests/project/test_documents.py puts it there, and asks it",
    "derated": "the same",
    "make": "`.ci/run` tests, `.ci/interpreters` does what `bench` does; `emulate` and `prove` take an hour",
    "python": "the suite runs these tests; `.ci/run` downloads",
}
"""Commands that another place runs."""


def left_out(page: str) -> Iterator[list[str]]:
    """The commands of a page that are typed nowhere else."""
    for _, typed in commands(page):
        words = shlex.split(typed)
        own = words[words[0] == "thrustbench" :]
        foreign = words[0] != "thrustbench" or own[0] in LONG or any(name in own for name in GIVEN)
        typed_there = own[:4] == ["run", "--vehicle", "my-rov.yaml", "--quick"]
        if foreign and not typed_there and not ELSEWHERE.keys() & {*own}:
            yield own


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what a reader has: a vehicle's files, a dive's logs, two trees, and two commits."""
    from tests.log_files import write_bag1
    from tests.output_logs import write_bin

    folder = tmp_path_factory.mktemp("desk")
    t = np.arange(4) / 50
    write_bag1(folder, t, np.ones((4, 6))).rename(folder / "dive.bag")
    write_bin(folder, t, np.full((4, 8), 1600), np.full(4, 15.0), np.zeros((4, 3)))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        CliRunner().invoke(bench.__main__.cli, ["init", "my-rov", "--like", "bluerov2-heavy"])
    for tree in ("A", "B", "."):
        shutil.copytree(ROOT / "alloc", folder / tree / "alloc", ignore=shutil.ignore_patterns("__pycache__"))
    gate_check.git(folder, "init", "--quiet", "--initial-branch=main")
    gate_check.commit(folder, "base")
    gate_check.git(folder, "switch", "--quiet", "--create", "work")
    for file in (folder / "alloc/methods/pinv.py", folder / "my_allocator.py"):
        file.write_text(f"{file.read_text()}# other bytes\n")
    gate_check.commit(folder, "head")
    return folder


def ready(words: list[str], folder: Path) -> list[str]:
    """The words with less to do, once what the command reads is there; skips where a tool is missing."""
    if words[0] == "emulate":
        available(words[words.index("--target") + 1])
    if "LOG" in words:  # what a board's line would have sent
        subprocess.run(["make", "-C", "ukwial-float", "log"], cwd=folder, check=True, capture_output=True)
        shutil.copy(folder / "ukwial-float/build/posix/LOG", folder / "LOG")
        return words
    if words[0] == "layouts":
        study = (ROOT / words[1]).read_text(encoding="utf-8")
        words[1] = "study.yaml"
        (folder / words[1]).write_text(re.sub(r"\bn: \d+", "n: 64", study))
    if words[0] == "gate" and "--plugin" not in words:
        return [*words, "--cells=ukwial:pinv:*"]
    if words[0] == "compare":
        shutil.copy(folder / "A.json", folder / "B.json")
    return words


@pytest.mark.parametrize("page", [page for page in PAGES if any(left_out(page))])
def test_what_takes_long_on_a_page_runs_with_less_to_do(
    page: str, desk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for tutorial in ("docs/your-vehicle.md", "docs/your-dive.md", page):
        saved(ROOT / tutorial, desk)
    shutil.copy(desk / "log.csv", desk / "dive.csv")
    monkeypatch.chdir(desk)
    for words in left_out(page):
        typed = [*ready(words, desk), *SMALL.get(words[0], ())]
        if words[0] == "pytest":
            benchmark(typed, desk)
        elif words[0] == "fleet":
            with loopback_cluster(desk) as cluster:
                cluster.worker()
                typed[typed.index("--scheduler") + 1] = cluster.address
                run(typed)
        else:
            run(typed)


def run(words: list[str]) -> None:
    """Run a command of the program; a busy machine may leave a gate without a verdict."""
    done = CliRunner().invoke(bench.__main__.cli, words, catch_exceptions=False, standalone_mode=False)
    assert done.return_value in ((0, None, 3) if words[0] == "gate" else (0, None)), done.output


def benchmark(words: list[str], folder: Path) -> None:
    """Run the suite of pytest-benchmark, which writes into the folder."""
    # pytest-benchmark switches itself off under xdist, whose variables would reach this run.
    alone = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    written = [str(folder / word) if word in ("A.json", "pictures/call") else word for word in words[1:]]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *written]
    done = subprocess.run(command, cwd=ROOT, env=alone, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
