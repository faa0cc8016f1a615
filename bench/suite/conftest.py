"""The suite's methods x vehicles x starts x labels, chosen on pytest's command line."""

from pathlib import Path

import pytest

from alloc import (
    Allocator,
    AllocError,
    Entry,
    NotApplicable,
    NotInstalled,
    Vehicle,
    catalogue,
    find,
    load_plugin,
    load_vehicle,
    prepare,
)
from bench.judging.question import Question
from bench.suite.answers import LABELS, question

VEHICLES = ("ukwial", "bluerov2-heavy")
"""Four thrusters in the plane, eight in 6 DOF; all vehicles would take an hour."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--vehicle``, ``--method`` and ``--plugin``, each as often as wanted."""
    group = parser.getgroup("thrustbench")
    group.addoption("--vehicle", action="append", metavar="NAME", help=f"default: {', '.join(VEHICLES)}")
    group.addoption("--method", action="append", metavar="NAME", help="default: all that are installed")
    group.addoption("--plugin", action="append", metavar="FILE", default=[], help="a method of your own")


def pytest_configure(config: pytest.Config) -> None:
    """Refuse an unknown name or a method that is not installed: pytest would skip its tests and pass."""
    try:
        for vehicle in config.getoption("vehicle") or ():
            load_vehicle(vehicle)
        for file in config.getoption("plugin"):
            load_plugin(Path(file))
        for method in config.getoption("method") or ():
            if missing := find(method).missing:
                raise NotInstalled(f"{method}: {missing}")
    except AllocError as error:
        raise pytest.UsageError(str(error)) from None


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Cross the fixtures that a test takes: ``vehicle``, ``label``, ``entry`` (a method), its ``start``."""
    option = metafunc.config.getoption
    if "vehicle" in metafunc.fixturenames:
        vehicles = [load_vehicle(name) for name in option("vehicle") or VEHICLES]
        metafunc.parametrize("vehicle", vehicles, ids=[v.name for v in vehicles], scope="session")
    if "label" in metafunc.fixturenames:
        metafunc.parametrize("label", LABELS if metafunc.function.__name__ == "test_call" else LABELS[:1])
    if "entry" in metafunc.fixturenames:
        plugged = [load_plugin(Path(file)) for file in option("plugin")]
        wanted = option("method") or [e.name for e in catalogue()] * (not plugged)
        entries = [e for e in catalogue() if not e.missing and e.name in wanted] + plugged
        if "start" in metafunc.fixturenames:
            rows = [(e, start) for e in entries for start in e.starts]
            ids = [f"{e.name} {start}".rstrip(" -") for e, start in rows]
            metafunc.parametrize(("entry", "start"), rows, ids=ids)
        else:
            metafunc.parametrize("entry", entries, ids=[e.name for e in entries])


@pytest.fixture
def start() -> str:
    """The method's own choice, for tests that do not go through all starts."""
    return "-"


@pytest.fixture
def asked(vehicle: Vehicle, label: str) -> Question:
    """Demands of one label; skips where the vehicle has none."""
    try:
        return question(vehicle, label)
    except NotApplicable as reason:
        pytest.skip(str(reason))


@pytest.fixture
def allocator(entry: Entry, vehicle: Vehicle, start: str) -> Allocator:
    """The method, prepared; skips where it refuses the vehicle."""
    try:
        return prepare(entry, vehicle, start=start)
    except NotApplicable as reason:
        pytest.skip(str(reason))
