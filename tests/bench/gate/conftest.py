"""One vehicle, what the gate asks of it, and the right answers."""

import pytest

from alloc import Allocation, Vehicle, build, load_vehicle
from bench.demands import DemandSet
from bench.gate.answers import first
from bench.gate.asked import (
    AXES,
    demand_sets,
)
from bench.judging.question import Question, ask_here, questions


@pytest.fixture(scope="session")
def vehicle() -> Vehicle:
    return load_vehicle("ukwial")


@pytest.fixture(scope="session")
def sets(vehicle: Vehicle) -> list[DemandSet]:
    return demand_sets(vehicle)


@pytest.fixture(scope="session")
def whole(sets: list[DemandSet]) -> Question:
    return questions(sets[:1], ask_here)[0]


@pytest.fixture(scope="session")
def question(whole: Question) -> Question:
    """The first demands: none, those on one axis and on two, and a hundred more of all kinds."""
    return first(whole, AXES + 113)


@pytest.fixture
def right(vehicle: Vehicle, question: Question) -> list[Allocation]:
    allocate = build("nullspace", vehicle)
    return [allocate(tau) for tau in question.demands.taus]
