"""The study of answers beyond the limits, on a few hundred cases; docs/saturation.md has the large ones."""

import pytest

from saturation import METHODS, against_programs, main, within_limits

methods = pytest.mark.parametrize("method", METHODS)


@methods
def test_shares_and_thrusts_are_those_of_programs(method: str) -> None:
    found = against_programs(method, 50)
    assert found.excluding > found.cases / 2
    assert found.shares >= found.cases
    assert found.share_off <= 1e-9
    assert found.thrust_off <= 1e-8
    assert found.unsolved == 0


@methods
def test_all_answers_are_finite_and_inside_their_limits_and_none_lies(method: str) -> None:
    found = within_limits(method, 300)
    assert found.good == found.calls == 300
    assert 0 < found.solved < 300
    assert found.lies == 0


def test_each_method_has_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    main("limits", "30")
    lines = capsys.readouterr().out.splitlines()
    assert all(any(f"| {method} " in line for line in lines) for method in METHODS)
