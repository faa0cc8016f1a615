"""The suite's methods x vehicles x starts x labels, chosen on pytest's command line.

By default: what one compares, in two minutes. ``--all`` adds the rest.
"""

import pytest

from alloc import Allocator, AllocError, NotApplicable, Vehicle, catalogue
from alloc.discovery import Entry, find, is_plugin, load_plugin, prepare
from alloc.errors import NotInstalled
from alloc.formulations import Family
from alloc.solvers import slow
from alloc.vehicle.file import load_fixed_vehicle
from bench.judging.question import Question
from bench.suite.answers import LABELS, MOVING, question

VEHICLES = ("ukwial", "bluerov2-heavy")
"""Four thrusters in the plane, eight in 6 DOF; all vehicles would take an hour."""
COMPARED = (Family.CLOSED_FORM, Family.EXACT, Family.LIVE)
"""Families whose methods are timed by default, but for slow ones: the paper's question is between them."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--vehicle``, ``--method`` and ``--plugin``, each as often as wanted, and ``--all``."""
    group = parser.getgroup("thrustbench")
    group.addoption("--vehicle", action="append", metavar="NAME", help=f"default: {', '.join(VEHICLES)}")
    group.addoption(
        "--method",
        action="append",
        metavar="NAME",
        help="or a file, or exec:COMMAND; default: closed forms, exact methods, live solvers",
    )
    group.addoption("--plugin", action="append", metavar="FILE", default=[], help="a method of your own")
    text = "every method with every start, limits that move, set-up and many(): some twenty minutes"
    group.addoption("--all", action="store_true", help=text)


def pytest_configure(config: pytest.Config) -> None:
    """Refuse an unknown name or a method that is not installed: pytest would skip its tests and pass."""
    try:
        for vehicle in config.getoption("vehicle") or ():
            load_fixed_vehicle(vehicle)
        named = config.getoption("method") or []
        config.option.plugin = [*config.option.plugin, *filter(is_plugin, named)]
        brought = {load_plugin(name).name for name in config.getoption("plugin")}
        for method in named:
            if method not in brought and not is_plugin(method) and (missing := find(method).missing):
                raise NotInstalled(f"{method}: {missing}")
    except AllocError as error:
        raise pytest.UsageError(str(error)) from None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out set-up and ``many`` unless all is asked for, or a file is named."""
    named = any(argument.partition("::")[0].endswith(".py") for argument in config.args)
    if not config.getoption("all") and not named:
        left_out = [item for item in items if not item.name.startswith("test_call[")]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item.name.startswith("test_call[")]


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Cross the fixtures that a test takes: ``vehicle``, ``label``, ``entry`` (a method), its ``start``."""
    option = metafunc.config.getoption
    if "vehicle" in metafunc.fixturenames:
        vehicles = [load_fixed_vehicle(name) for name in option("vehicle") or VEHICLES]
        metafunc.parametrize("vehicle", vehicles, ids=[v.name for v in vehicles], scope="session")
    if "label" in metafunc.fixturenames:
        of_calls = (*LABELS, MOVING) if option("all") else LABELS
        metafunc.parametrize("label", of_calls if metafunc.function.__name__ == "test_call" else LABELS[:1])
    if "entry" in metafunc.fixturenames:
        plugged = [load_plugin(name) for name in dict.fromkeys(option("plugin"))]
        every = option("all")
        compared = [
            e
            for e in catalogue()
            if every or (e.family in COMPARED and not e.named_only and e.solver not in slow())
        ]
        usual = [] if plugged else [e.name for e in compared]
        wanted = option("method") or usual
        entries = [e for e in catalogue() if not e.missing and e.name in wanted] + plugged
        if "start" in metafunc.fixturenames:
            rows = [(e, start) for e in entries for start in (e.starts if every else _best(e.starts))]
            ids = [f"{e.name} {start}".rstrip(" -") for e, start in rows]
            metafunc.parametrize(("entry", "start"), rows, ids=ids)
        else:
            metafunc.parametrize("entry", entries, ids=[e.name for e in entries])


def _best(starts: tuple[str, ...]) -> tuple[str, ...]:
    """The start that a vehicle would run a method with."""
    return ("reused",) if "reused" in starts else starts[:1]


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
