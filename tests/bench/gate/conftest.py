"""One vehicle, what the gate asks of it, and the right answers."""

from collections.abc import Iterator

import pytest

from alloc import Allocation, Vehicle, build, load_vehicle
from bench.demands import DemandSet
from bench.gate import questions as gate_questions
from bench.gate.questions import AXES, demand_sets
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
    return whole.rows(slice(AXES + 113))


@pytest.fixture
def right(vehicle: Vehicle, question: Question) -> list[Allocation]:
    allocate = build("nullspace", vehicle)
    return [allocate(tau) for tau in question.demands.taus]


@pytest.fixture(scope="module")
def few_demands(sets: list[DemandSet]) -> Iterator[None]:
    """The gate asks a twentieth of its demands; ``sets``, which outlive this, are made before it."""
    with pytest.MonkeyPatch.context() as patch:
        few = {kind: n // 20 for kind, n in gate_questions.LOOKED_AT.items()}
        patch.setattr(gate_questions, "LOOKED_AT", few)
        for name, count in (("EDGES", 25), ("JOLTS", 150), ("ONE_SIDE", 20), ("HARD_DEMANDS", 40)):
            patch.setattr(gate_questions, name, count)
        gate_questions.nearly_symmetric.cache_clear()
        yield
    gate_questions.nearly_symmetric.cache_clear()
