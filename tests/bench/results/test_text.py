"""Numbers and lines of tables, as readers see them."""

import numpy as np
import pytest

from bench.results.text import RARE, drop_rounding, merge_lines, rarity, wrench_text


def test_names_with_equal_cells_share_the_line_of_the_first() -> None:
    lines = [("a", ["1"]), ("b", ["2"]), ("c", ("1",))]
    assert merge_lines(lines) == [["a, c", "1"], ["b", "2"]]


def test_a_wrench_is_told_by_axis_with_units() -> None:
    assert wrench_text(["surge", "yaw"], [-10.0, 2.0]) == "surge -10.0 N, yaw 2.00 N m"


def test_rounding_of_either_sign_is_zero_and_a_loss_is_not() -> None:
    assert [drop_rounding(value) for value in (None, -1e-9, 1e-6, 2e-6)] == [None, 0.0, 0.0, 2e-6]


@pytest.mark.parametrize("n", [50, 500, 2000])
def test_more_of_a_set_than_is_said_is_worse_than_the_worst_of_n_in_one_of_20_000_draws(n: int) -> None:
    """The share beyond the largest of n even numbers has the law of the least of n: (1 - x)^n."""
    assert (1 - RARE / n) ** n < 1 / 20_000
    beyond = np.random.default_rng(3).random((5000, n)).min(axis=1)
    assert np.mean(beyond > 2 / n) == pytest.approx((1 - 2 / n) ** n, abs=0.02)
    assert np.mean(beyond > RARE / n) < 1 / 1000


def test_a_rare_share_is_said_with_two_digits() -> None:
    assert [rarity(n) for n in (5, 50, 2000)] == ["less than 100 %", "less than 20 %", "less than 0.5 %"]
