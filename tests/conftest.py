"""Fixtures that several test files share."""

import gc
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Generator, Iterator
from compileall import compile_dir
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from alloc import Vehicle, catalogue, list_vehicles, load_vehicle
from alloc.discovery import Entry
from alloc.formulations import Family
from alloc.nullspace.structure import decompose
from bench.chips.toolchain import scratch
from tests.places import ROOT

# No deadline, and slow examples are no error, since a busy machine is not the code's fault. Examples are
# the same in every run, so that a red test comes from a change.
BUSY = [HealthCheck.too_slow]
settings.register_profile("thrustbench", deadline=None, derandomize=True, suppress_health_check=BUSY)
settings.load_profile("thrustbench")

# Colour what is compared as plain text; set in a git hook, where git commands in a test's own repository
# would change the user's; and make's own, with which a make that a test runs warns of a jobserver.
OF_COLOURS = ("FORCE_COLOR", "PY_COLORS")
OF_GIT = ("GIT_DIR", "GIT_INDEX_FILE", "GIT_WORK_TREE")
OF_MAKE = ("MAKEFLAGS", "MAKELEVEL")
for name in (*OF_COLOURS, *OF_GIT, *OF_MAKE):
    os.environ.pop(name, None)

# Kernels are compiled into the tree, since the default folder lies in a home, which tests may not have.
os.environ.setdefault("THRUSTBENCH_CACHE", str(ROOT / "build" / "kernels"))

# Each run of the tests has a temporary folder of its own: what a test leaves there is named at the end.
# Workers of pytest-xdist share their parent's. Folders of tmp_path stay where they always are.
IS_WORKER = "PYTEST_XDIST_WORKER" in os.environ
if not IS_WORKER:
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", tempfile.gettempdir())
    os.environ["TMPDIR"] = tempfile.tempdir = tempfile.mkdtemp(prefix="thrustbench-tests-")

# Bytecode of the packages and of tests is kept also where the environment forbids it: each worker and each
# process that a test starts would compile all that it imports. What a test itself writes stays without.
NO_BYTECODE, sys.dont_write_bytecode = sys.dont_write_bytecode, False
if not IS_WORKER:
    for package in ("alloc", "bench"):
        compile_dir(ROOT / package, quiet=2)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_sessionfinish(session: pytest.Session) -> Generator[None, object, object]:
    """A run fails that leaves something in the temporary folder, but for what goes as its process ends."""
    result = yield
    if not IS_WORKER:
        folder = Path(os.environ["TMPDIR"])
        own = {scratch()} if scratch.cache_info().currsize else set()
        if left := sorted(each.name for each in set(folder.iterdir()) - own):
            line = f"tests left {', '.join(left)} in the temporary folder; remove each where it is made"
            session.config.get_terminal_writer().line(line, red=True)
            session.exitstatus = session.exitstatus or pytest.ExitCode.TESTS_FAILED
        shutil.rmtree(folder, ignore_errors=True)
    return result


shipped = cache(load_vehicle)
"""A shipped vehicle, its file read once: nothing can be written into it."""


def structure(name: str) -> tuple[object, ...]:
    """Structure that decides a shipped vehicle's way through the code: k, n, rank, null space's blocks."""
    vehicle = shipped(name)
    return vehicle.k, vehicle.n, vehicle.rank, *(block.N.shape for block in decompose(vehicle).blocks)


FIRST = {structure(name): name for name in reversed(list_vehicles())}
"""The first of the shipped vehicles that share a structure."""
SOLVERS_SEE = ("bluerov2", "supply-vessel")
"""The vehicles that solvers are asked about: T without full rank, and a null space of three dimensions."""


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Tests live until the end: to look for garbage among thousands took a quarter of collecting them."""
    gc.disable()
    try:
        return (yield)
    finally:
        sys.dont_write_bytecode = NO_BYTECODE
        gc.enable()
        gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A solver gets the numbers of every vehicle by the same code, as does C where a thruster is off.

    About the other vehicles they are asked in CI.
    """
    for item in items:
        given: dict[str, object] = getattr(getattr(item, "callspec", None), "params", {})
        entry, vehicle = given.get("entry"), given.get("vehicle")
        if not isinstance(entry, Entry) or not isinstance(vehicle, str) or vehicle in SOLVERS_SEE:
            continue
        solves = entry.solver and entry.family is not Family.GENERATED
        if solves or (entry.twin and given.get("case") is not None):
            item.add_marker(pytest.mark.long)


@pytest.fixture(
    params=[
        pytest.param(name, marks=() if name in FIRST.values() else pytest.mark.long)
        for name in list_vehicles()
    ],
    scope="session",
)
def vehicle(request: pytest.FixtureRequest) -> Vehicle:
    """Each shipped vehicle in turn; those whose structure an earlier one has are asked with ``-m long``."""
    return shipped(request.param)


@pytest.fixture(params=[e for e in catalogue() if not e.missing], ids=lambda e: e.name, scope="session")
def entry(request: pytest.FixtureRequest) -> Entry:
    """Each method that can be built here in turn."""
    method: Entry = request.param
    return method


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """SIGINT raises KeyboardInterrupt, also where the tests run in the background.

    Scripts and cron start background processes with SIGINT ignored; Python and its children keep that.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def rng() -> np.random.Generator:
    """A seeded generator: the same numbers in every run."""
    return np.random.default_rng(2004)
