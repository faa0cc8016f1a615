"""What several test files share: the catalogue crossed with the vehicles."""

import os
import signal
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import settings

from alloc import Entry, Vehicle, catalogue, list_vehicles, load_vehicle
from tests.places import ROOT

# No deadline: a busy machine is not the code's fault. The same examples in every run: a red test is news.
settings.register_profile("thrustbench", deadline=None, derandomize=True)
settings.load_profile("thrustbench")

# Kernels are compiled into the tree: a home, where users' lie, may be missing or read-only.
os.environ.setdefault("THRUSTBENCH_CACHE", str(ROOT / "build" / "kernels"))


@pytest.fixture(params=list_vehicles(), scope="session")
def vehicle(request: pytest.FixtureRequest) -> Vehicle:
    """Each shipped vehicle in turn."""
    return load_vehicle(request.param)


@pytest.fixture(params=[e for e in catalogue() if not e.missing], ids=lambda e: e.name, scope="session")
def entry(request: pytest.FixtureRequest) -> Entry:
    """Each method that can be built here in turn."""
    found: Entry = request.param
    return found


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Ctrl-C is heard, also where the tests were started in the background by a script or by cron.

    There SIGINT is ignored, which children inherit and Python respects.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def rng() -> np.random.Generator:
    """A seeded generator: the same numbers in every run."""
    return np.random.default_rng(2004)
