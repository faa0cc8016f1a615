"""The study of sentences on fresh demands, on one small vehicle with few of them."""

import numpy as np
import pytest

import fresh_demands
from alloc import Vehicle, load_vehicle
from alloc.allocation import FloatArray
from bench.judging.capability import even_demands

METHODS = ["nullspace", "scaled", "pinv"]


def test_sentences_of_a_run_hold_of_fresh_demands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fresh_demands, "FRESH", 3000)
    assert list(fresh_demands.failed_sentences(load_vehicle("ukwial"), METHODS)) == []


def test_a_sentence_on_demands_that_were_too_easy_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small demands, of which pinv misses none; by nullspace nothing is lost of any."""

    def demands(vehicle: Vehicle, seed: int, n: int = 200) -> FloatArray:
        return (1.0 if seed else 0.1) * even_demands(vehicle, seed, n)

    monkeypatch.setattr(fresh_demands, "FRESH", 3000)
    monkeypatch.setattr(fresh_demands, "even_demands", demands)
    monkeypatch.setattr(fresh_demands, "limit_wrenches", lambda vehicle: np.zeros((0, vehicle.k)))
    found = list(fresh_demands.failed_sentences(load_vehicle("ukwial"), METHODS))
    assert found[0].startswith("pinv lost nothing, but ")
    assert len(found) == 3  # and it is worse than its worst, of what is missed and of turns
    assert all(sentence.startswith("pinv ") for sentence in found)


@pytest.mark.parametrize(("beyond", "fails"), [(4, False), (5, True)])
def test_half_a_per_cent_of_others_may_be_worse(beyond: int, fails: bool) -> None:
    others = np.array([0.9] * beyond + [0.1] * (1000 - beyond))
    found = list(fresh_demands.exceeded("pinv missed 0.5 at worst", 0.5, others, "missed {:.3g}"))
    assert found == ["pinv missed 0.5 at worst, but 0.500 % of 1,000 others: missed 0.9"] * fails
