"""What several test files share: the catalogue crossed with the vehicles."""

import numpy as np
import pytest

from alloc import Entry, Vehicle, catalogue, list_vehicles, load_vehicle


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
def rng() -> np.random.Generator:
    """A seeded generator: the same numbers in every run."""
    return np.random.default_rng(2004)
