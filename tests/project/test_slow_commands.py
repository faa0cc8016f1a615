"""Every command of every page is run, with less to do; a list says which another place runs.

``test_typed_commands`` types those that take no time. Here are the others, those within sentences, and those
that ``make emulate`` and ``make prove`` give.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner

import bench.__main__
import gate_check
from alloc import load_vehicle
from alloc.c import missing
from alloc.rivals.download import source
from bench.inputs.starter import LANGUAGES, plugin
from tests.analysers import needs_frama_c
from tests.clusters import loopback_cluster
from tests.compilers import needs
from tests.dives import dive, write_dive
from tests.emulators import available
from tests.pages import saved
from tests.places import ROOT, other_pytest
from tests.project.test_typed_commands import GIVEN, PAGES, SHORT, commands, in_prose, too_long

pytestmark = [pytest.mark.long, pytest.mark.skipif(bool(missing()), reason=missing() or "-")]

STUDIES = "docs/studies/"
SMALL = {
    "run": SHORT,
    "export": ("--n=2",),
    "gate": ("--pairs=2", "--threshold=900", "--no-instructions"),
    "emulate": ("--n=2", "--demands=inactive", "--method=pinv@native"),
    "prove": ("--vehicle=ukwial", "--method=pinv@native"),
    "board": ("--n=2", "--method=nullspace@native"),
    "layouts": ("--n=64", "--workers=1"),
    "fleet": SHORT,
    "pytest": ("--vehicle=ukwial", "--method=pinv", "--benchmark-max-time=0.001", "--benchmark-warmup=off"),
    "qpbenchmark": ("--solver=daqp", "--problem=ukwial-inactive-0"),
    f"{STUDIES}campaign.py": ("--vehicles=1", "--method=nullspace"),
    f"{STUDIES}clip_price.py": ("ukwial",),
    f"{STUDIES}gate_answers.py": ("--trials=1", "--cells=1"),
    f"{STUDIES}native_speed.py": ("ukwial", "--rounds=1"),
    f"{STUDIES}rational.py": ("--problems=2", "--method=nullspace"),
}
"""Options of a command beside those on the page, so that it takes seconds."""
ELSEWHERE = {
    ". .venv/bin/activate": (".ci/wheel", 'PATH="$place/venv/bin:$PATH"'),
    "dask": ("tests/clusters.py", '"-m", "dask"'),
    "make .venv/all": (".ci/run", "make .venv/all"),
    "make bench": (".ci/interpreters", "thrustbench run"),
    "make docs": (".github/workflows/docs.yml", "make docs"),
    "make elsewhere": (".ci/run", ".ci/elsewhere user"),
    "make emulate": ("Makefile", "thrustbench emulate"),
    "make keep": ("tests/project/test_keep.py", '["make", "--no-print-directory", "keep"'),
    "make prove": ("Makefile", "thrustbench prove"),
    "make test": (".ci/run", "make test"),
    "pip install": (".ci/interpreters", "install --quiet --dry-run --constraint constraints.txt"),
    "python -m alloc.rivals.download": (".ci/run", "-m alloc.rivals.download"),
    "python -m bench.chips.install": (".ci/run", "-m bench.chips.install"),
    "python -m bench.proof.install": (".ci/run", "-m bench.proof.install"),
    "python -m pytest -n 2": ("Makefile", "-m pytest -n 2"),
    "python -m pytest tests/bench/gate": ("Makefile", "-m pytest -n 2"),
    "python -m pytest tests/alloc/nullspace": ("Makefile", "-m pytest -n 2"),
    "python docs/studies/cross_check.py": (
        "tests/studies/test_cross_check.py",
        "from cross_check import ours",
    ),
    "python docs/studies/eiquadprog.py FOLDER": (
        "tests/studies/test_eiquadprog.py",
        "eiquadprog.main(tmp_path)",
    ),
    "python docs/studies/flown_cycles.py FOLDER": (
        "tests/bench/chips/test_flash.py",
        "from flown_cycles import",
    ),
    "python docs/studies/page_tables.py": ("tests/studies/test_page_tables.py", "page_tables.TABLES[name]"),
    "python docs/studies/sabotage.py": ("tests/bench/proof/test_proof.py", "for each in SABOTAGES"),
    "python docs/studies/solver_defects.py": ("tests/alloc/solvers/test_solvers_docs.py", "programs()"),
    "python docs/studies/what_flies.py FOLDER": (
        "tests/studies/test_what_flies.py",
        "what_flies.rows(sets",
    ),
    "ruff check": ("Makefile", "ruff check ."),
    "thrustbench emulate --vehicle ukwial --target cortex-m7": (
        ".ci/run",
        "thrustbench emulate --vehicle ukwial --target cortex-m7",
    ),
    "thrustbench prove --library": ("tests/bench/proof/test_library.py", '"--library"'),
    "thrustbench prove --vehicle ukwial": (".ci/run", "thrustbench prove --vehicle ukwial"),
    "thrustbench report": ("tests/bench/report/test_report.py", '["report"]'),
}
"""Commands that another place runs, and words that stand there: what tests or installs the project itself,
and what takes minutes.

What ``make emulate`` and ``make prove`` give is run here, command by command. ``flown_cycles`` compiles C
that is not ours and that CI lacks; its parts are tested."""


def recipe(target: str) -> list[str]:
    """The commands that ``make`` gives for a target."""
    rule = re.search(rf"^{target}:.*\n((?:\t.*\n)+)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert rule
    return [line.strip().removeprefix("$(BIN)/") for line in rule[1].splitlines()]


@cache
def every() -> dict[str, str]:
    """Each command of the pages, and the first page that has it."""
    found: dict[str, str] = {}
    for page in PAGES:
        here = [typed for _, typed in commands(page)]
        here += in_prose((ROOT / page).read_text(encoding="utf-8"))
        for typed in here:
            if typed in ("make emulate", "make prove"):
                found |= {own: page for own in recipe(typed.removeprefix("make ")) if own not in found}
            found.setdefault(typed, page)
    return found


@cache
def in_blocks() -> set[str]:
    """The commands that stand on lines of their own, and not only within sentences."""
    return {typed for page in PAGES for _, typed in commands(page)}


def typed_in_full(words: list[str]) -> bool:
    """True if ``test_typed_commands`` runs a command as it stands."""
    own = words[1:]
    known = own[0] in bench.__main__.cli.list_commands(click.Context(bench.__main__.cli))
    quick = own[:4] == ["run", "--vehicle", "my-rov.yaml", "--quick"]
    return quick or (known and not too_long(own) and not any(name in own for name in GIVEN))


def left_out(page: str) -> Iterator[list[str]]:
    """The commands that are run here, at the first page that has them.

    One that is named alone, or with some of the options that it has elsewhere, is run there.
    """
    found = every()
    split = {typed: shlex.split(typed) for typed in found}
    for typed, first in found.items():
        words = split[typed]
        if first != page or any(typed.startswith(place) for place in ELSEWHERE):
            continue
        more = any(set(words) < set(other) and words[:2] == other[:2] for other in split.values())
        if not more and not (words[0] == "thrustbench" and typed in in_blocks() and typed_in_full(words)):
            yield words[words[0] == "thrustbench" :]


@pytest.mark.parametrize("typed", ELSEWHERE)
def test_a_command_that_another_place_runs_is_on_a_page_and_in_that_place(typed: str) -> None:
    place, words = ELSEWHERE[typed]
    assert any(each.startswith(typed) for each in every())
    assert words in (ROOT / place).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what a reader has: two vehicles' files, a dive's logs, two trees, and two commits."""
    from tests.log_files import write_bag1
    from tests.output_logs import write_bin

    folder = tmp_path_factory.mktemp("desk")
    t = np.arange(4) / 50
    write_bag1(folder, t, np.ones((4, 6))).rename(folder / "dive.bag")
    write_bin(folder, t, np.full((4, 8), 1600), np.full(4, 15.0), np.zeros((4, 3)))
    for name in ("results", "docs"):
        (folder / name).symlink_to(ROOT / name)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        CliRunner().invoke(bench.__main__.cli, ["init", "my-rov", "--like", "bluerov2-heavy"])
    shutil.copy(ROOT / "alloc/vehicles/azimuth/double-ended-ferry.yaml", folder / "my-ferry.yaml")
    rov = (folder / "my-rov.yaml").read_text(encoding="utf-8")
    (folder / "fused.yaml").write_text(f"{rov}cap: {{amps: 25, reserve: 3}}\n", encoding="utf-8")
    heavy = load_vehicle("bluerov2-heavy")
    write_dive(folder / "motion.csv", heavy, dive(heavy, np.random.default_rng(4), np.ones(heavy.n)))
    for language in ("cpp", "exec"):
        for name, text in plugin("My allocator", language).items():
            (folder / name).write_text(text, encoding="utf-8")
    (folder / "my_allocator").chmod(0o755)
    if shutil.which("cmake"):
        subprocess.run(LANGUAGES["cpp"].build, shell=True, cwd=folder, check=True, capture_output=True)
    for tree in ("A", "B", "."):
        shutil.copytree(ROOT / "alloc", folder / tree / "alloc", ignore=shutil.ignore_patterns("__pycache__"))
    gate_check.git(folder, "init", "--quiet", "--initial-branch=main")
    gate_check.commit(folder, "base")
    gate_check.git(folder, "switch", "--quiet", "--create", "work")
    for file in (folder / "alloc/methods/pinv.py", folder / "my_allocator.py"):
        file.write_text(f"{file.read_text()}# other bytes\n")
    gate_check.commit(folder, "head")
    return folder


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A tree to which a reader has added a method, a solver and a formulation, as the pages say."""
    folder = tmp_path_factory.mktemp("tree")
    for name in ("alloc", "bench", "tests", "docs"):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(ROOT / "pyproject.toml", folder)
    for name in ("method", "solver", "formulation"):
        saved(ROOT / f"docs/add-a-{name}.md", folder)
    methods = folder / "alloc/methods"
    shutil.copy(folder / "damped.py", methods)
    clip = (methods / "clip.py").read_text(encoding="utf-8")
    (methods / "mine.py").write_text(clip.replace('FORMULATION = "clip"', 'FORMULATION = "mine"'))
    return folder


def ready(words: list[str], folder: Path) -> list[str]:
    """The words with less to do, once what the command reads is there; skips where a tool is missing."""
    if words[0] == "emulate" and "--target" in words:
        available(words[words.index("--target") + 1])
    elif words[0] == "emulate":
        available("cortex-m4f")
        words += ["--target=cortex-m4f", "--float", "--limits=fixed"]
        words += [] if "--vehicle" in words else ["--vehicle=bluerov2-heavy"]
    if words[0] == "prove":
        needs_frama_c()
    if LANGUAGES["cpp"].method in words:
        needs("cmake")
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
    if "CSRC" in words:  # where DAQP's C was downloaded, as .ci/run does
        daqp = source("daqp")
        if why := daqp.missing():
            pytest.skip(why)
        shutil.unpack_archive(daqp.path, folder, filter="data")
        words[words.index("CSRC")] = str(next(folder.glob("daqp-*/csrc")))
    if words[-1].endswith(".svg"):  # docs/ in the folder is the project's
        words[-1] = Path(words[-1]).name
    if words[-1] == "qp/NAME":
        return ["python", words[1], "30", "qp/daqp"]
    return words


@pytest.mark.parametrize("page", [page for page in PAGES if any(left_out(page))])
def test_what_takes_long_on_a_page_runs_with_less_to_do(
    page: str, desk: Path, tree: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for tutorial in ("docs/your-vehicle.md", "docs/your-dive.md", page):
        saved(ROOT / tutorial, desk)
    shutil.copy(desk / "log.csv", desk / "dive.csv")
    monkeypatch.chdir(desk)
    for words in left_out(page):
        typed = ready(list(words), desk)
        typed += SMALL.get(words[1] if words[0] == "python" else words[0], ())
        if words[0] == "pytest":
            benchmark(typed, desk)
        elif words[0] in ("python", "qpbenchmark") or {"qp/slsqp", "derated", "mine"} & set(words):
            outside(typed, desk, tree)
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


def outside(words: list[str], desk: Path, tree: Path) -> None:
    """Run a study or a tool in the reader's folder, and in the reader's tree what needs that."""
    place = desk if (desk / words[1]).exists() else tree
    if words[0] == "python":
        command = [sys.executable, *words[1:]]
    elif words[0] == "qpbenchmark":
        place, command = desk, [str(Path(sys.executable).parent / words[0]), *words[1:]]
    else:
        command = [sys.executable, "-m", "bench", *words]
    path = os.pathsep.join([str(tree if place == tree else ROOT), str(ROOT / STUDIES)])
    done = subprocess.run(
        command,
        cwd=place,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def benchmark(words: list[str], folder: Path) -> None:
    """Run the suite of pytest-benchmark, which writes into the folder."""
    # pytest-benchmark switches itself off under xdist, whose variables would reach this run.
    alone = other_pytest()
    written = [str(folder / word) if word in ("A.json", "pictures/call") else word for word in words[1:]]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *written]
    done = subprocess.run(command, cwd=ROOT, env=alone, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
