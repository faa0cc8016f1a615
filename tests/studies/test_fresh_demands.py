"""The study of sentences on fresh demands, on one small vehicle with few of them."""

import numpy as np
import pytest

import fresh_demands
from alloc import Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from bench.judging.capability import even_demands
from bench.judging.unannounced import delivered_shares, failed_thrusts

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
    failures = [sentence for sentence in found if " with thruster " in sentence]
    others = [sentence for sentence in found if sentence not in failures]
    assert len(others) == 3  # and it is worse than its worst, of what is missed and of turns
    assert all(sentence.startswith("pinv ") for sentence in others)
    assert any(" off, announced, missed " in sentence for sentence in failures)


def test_sentences_on_failures_autopilots_and_caps_fail_on_easy_demands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    vehicle = load_vehicle("bluerov2")
    pinv, others = build("pinv", vehicle), even_demands(vehicle, 1, 1000)
    F = pinv.many(others)[0]
    easy = np.argsort(-delivered_shares(vehicle, others, failed_thrusts(vehicle, F, 0, "off"))[0])[:500]
    found = list(fresh_demands.failed_failures(vehicle, "pinv", (others[easy], F[easy]), (others, F)))
    assert any(sentence.startswith("pinv with thruster 0 off missed ") for sentence in found)
    assert list(fresh_demands.failed_failures(vehicle, "pinv", (others, F), (others, F))) == []
    missed = fresh_demands.losses(vehicle, build("ardusub", vehicle), others)[0]
    (sentence,) = fresh_demands.failed_mixer(vehicle, others[np.argsort(missed)[:200]], others)
    assert sentence.startswith("ardusub cost ")
    assert list(fresh_demands.failed_mixer(vehicle, others[:500], others[500:])) == []

    def ways(vehicle: Vehicle, taus: FloatArray) -> dict[str, tuple[FloatArray, FloatArray]]:
        worse = len(taus) != fresh_demands.DIRECTIONS
        return {"a way": (np.full(len(taus), 0.5 if worse else 1.0), np.full(len(taus), 1.0 + worse))}

    def bounds(vehicle: Vehicle, way: str, taus: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.full(len(taus), 0.25), np.full(len(taus), 4.0)

    monkeypatch.setattr(fresh_demands, "FRESH", 1000)
    monkeypatch.setattr(fresh_demands, "compare_ways", ways)
    monkeypatch.setattr(fresh_demands, "way_bounds", bounds)
    share, current = fresh_demands.failed_fuse(vehicle)
    assert share == "a way: worst share 1, but 100 % of 1,000 others: -0.5"
    assert current == "a way: worst current 1, but 100 % of 1,000 others: 2"
    assert list(fresh_demands.failed_fuse(load_vehicle("ukwial"))) == []  # without currents


@pytest.mark.parametrize(("beyond", "fails"), [(4, False), (5, True)])
def test_half_a_per_cent_of_others_may_be_worse(beyond: int, fails: bool) -> None:
    others = np.array([0.9] * beyond + [0.1] * (1000 - beyond))
    found = list(fresh_demands.exceeded("pinv missed 0.5 at worst", 0.5, others, "missed {:.3g}"))
    assert found == ["pinv missed 0.5 at worst, but 0.500 % of 1,000 others: missed 0.9"] * fails
