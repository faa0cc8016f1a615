"""What the suite times: methods x vehicles x starts, chosen on pytest's command line."""

import pytest

from alloc import Allocator, NotApplicable, Vehicle, build, catalogue, load_vehicle

VEHICLES = ("ukwial", "bluerov2-heavy", "supply-vessel")
"""Small, eight thrusters in 6 DOF, and hundreds of kN: one of each kind, or it takes an hour."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--vehicle`` and ``--method``, each as often as wanted."""
    group = parser.getgroup("thrustbench")
    group.addoption("--vehicle", action="append", metavar="NAME", help=f"default: {', '.join(VEHICLES)}")
    group.addoption("--method", action="append", metavar="NAME", help="default: all that are installed")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Cross what a test asks for: ``vehicle``, and ``method`` with its ``start``."""
    if "vehicle" in metafunc.fixturenames:
        names = metafunc.config.getoption("vehicle") or VEHICLES
        vehicles = [load_vehicle(name) for name in names]
        metafunc.parametrize("vehicle", vehicles, ids=[v.name for v in vehicles], scope="session")
    if "method" in metafunc.fixturenames:
        wanted = metafunc.config.getoption("method")
        entries = [e for e in catalogue() if not e.missing and (not wanted or e.name in wanted)]
        if "start" in metafunc.fixturenames:
            rows = [(e.name, start) for e in entries for start in e.starts]
            metafunc.parametrize(("method", "start"), rows, ids=[" ".join(row).rstrip(" -") for row in rows])
        else:
            metafunc.parametrize("method", [e.name for e in entries])


@pytest.fixture
def start() -> str:
    """The method's own choice, where a test does not go through them."""
    return "-"


@pytest.fixture
def allocator(method: str, vehicle: Vehicle, start: str) -> Allocator:
    """The method, prepared; skips where the method refuses the vehicle."""
    try:
        return build(method, vehicle, start=start)
    except NotApplicable as reason:
        pytest.skip(str(reason))
