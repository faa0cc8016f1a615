"""The study of random boats: right answers are proven, and each kind of wrong one is counted."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

import azimuths
from alloc import Allocation, Status, Vehicle, build
from alloc.allocation import FloatArray, StatusArray
from bench.demands.boats import boats

Answers = tuple[FloatArray, StatusArray]
BOAT = next(boat for boat in boats(40) if boat.nullity == 2)


def test_all_answers_for_a_few_boats_are_proven_right() -> None:
    found = azimuths.Counter[str]()
    for i, boat in enumerate(boats(8)):
        found.update(azimuths.study(boat, i, 60, 2))
    assert found["nullspace answers"] > 100
    assert found["qp/daqp answers"] > 40
    for name in ("nullspace", "scaled", "qp/daqp"):
        assert found[f"{name} wrong"] == found[f"{name} gave none"] == 0
    assert found["shares that differ"] == found["thrusts that differ"] == 0


def shorter(F: FloatArray, status: StatusArray) -> Answers:
    return 0.999 * F, status


def costlier(F: FloatArray, status: StatusArray) -> Answers:
    across = np.linalg.svd(BOAT.TP)[2][BOAT.rank]
    return F + 1e-4 * BOAT.f_scale * across, status


def infeasible(F: FloatArray, status: StatusArray) -> Answers:
    return F * np.nan, np.full_like(status, Status.INFEASIBLE)


def outside(F: FloatArray, status: StatusArray) -> Answers:
    return F * 100.0, status


@pytest.mark.parametrize("method", ["nullspace", "scaled"])
@pytest.mark.parametrize("wrong", [shorter, costlier, infeasible, outside])
def test_a_wrong_answer_is_counted(
    method: str, wrong: Callable[[FloatArray, StatusArray], Answers], monkeypatch: pytest.MonkeyPatch
) -> None:
    taus, reach = azimuths.ask(BOAT, np.random.default_rng(1), 80)
    inside = reach > 1.1
    right = azimuths.judge(method, BOAT, taus[inside])
    assert right[f"{method} wrong"] == 0

    def wronged(name: str, vehicle: Vehicle) -> object:
        allocate = build(name, vehicle)
        fake = SimpleNamespace(many=lambda taus: wrong(*allocate.many(taus)), tolerance=allocate.tolerance)
        return fake if name == method else allocate

    monkeypatch.setattr(azimuths, "build", wronged)
    found = azimuths.judge(method, BOAT, taus[inside])
    assert found[f"{method} wrong"] == inside.sum() > 20


class Early:
    """Answers of scaled that stop at 0.999 of the largest share, and say so."""

    tolerance = 1e-9

    def __init__(self) -> None:
        self._scaled = build("scaled", BOAT)

    def __call__(self, tau: FloatArray) -> Allocation:
        """Allocate one wrench (k,)."""
        found = self._scaled(tau)
        return found._replace(f=0.999 * found.f, share=(0.999 * found.share[0],))

    def many(self, taus: FloatArray) -> Answers:
        """Allocate wrenches (N, k)."""
        F, status = self._scaled.many(taus)
        return 0.999 * F, status


def test_a_share_that_stops_early_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    taus, reach = azimuths.ask(BOAT, np.random.default_rng(2), 80)
    beyond = taus[reach < 0.99]
    monkeypatch.setattr(azimuths, "build", lambda *_: Early())
    assert azimuths.judge("scaled", BOAT, beyond)["scaled wrong"] == len(beyond) > 10
