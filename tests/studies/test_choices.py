"""The study of quick and long runs, on one small vehicle with few demands."""

import pytest

import choices
from alloc import load_vehicle


def test_choices_come_of_answers_alone_and_are_those_of_a_longer_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choices, "N", 8)
    monkeypatch.setattr(choices, "TENFOLD", 3)
    monkeypatch.setattr(choices, "N_DEMANDS", 40)
    monkeypatch.setattr(choices, "REPEATS", 2)
    vehicle = load_vehicle("ukwial")
    pairs = choices.compared(vehicle)
    assert pairs == choices.compared(vehicle)  # no clock has a part
    short, long, *_ = pairs[0]
    assert short.first == long.first
    assert short.first.startswith("scaled")
    assert len(pairs) > 3  # what comes first is left out, and the rest compared again
    assert "scaled" not in pairs[1].short.first.split()


def test_generated_c_is_judged_as_its_twin_and_timed_on_its_own() -> None:
    vehicle = load_vehicle("ukwial")
    run = choices.made_run(vehicle, choices.served(vehicle, 0), 4)
    rows = {(row.method, row.demands): row for row in run.rows}
    for (method, demands), row in rows.items():
        twin = rows.get((method.removesuffix("@native"), demands))
        if method.endswith("@native") and twin is not None:
            assert row.measured.judged == twin.measured.judged
            assert row.call_p50_us == pytest.approx(choices.times_us()[method], rel=0.02)
    assert any(method.endswith("@native") for method, _ in rows)
