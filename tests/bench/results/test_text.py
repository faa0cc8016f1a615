"""Numbers and lines of tables, as readers see them."""

from bench.results.text import drop_rounding, merge_lines, wrench_text


def test_names_with_equal_cells_share_the_line_of_the_first() -> None:
    lines = [("a", ["1"]), ("b", ["2"]), ("c", ("1",))]
    assert merge_lines(lines) == [["a, c", "1"], ["b", "2"]]


def test_a_wrench_is_told_by_axis_with_units() -> None:
    assert wrench_text(["surge", "yaw"], [-10.0, 2.0]) == "surge -10.0 N, yaw 2.00 N m"


def test_rounding_of_either_sign_is_zero_and_a_loss_is_not() -> None:
    assert [drop_rounding(value) for value in (None, -1e-9, 1e-6, 2e-6)] == [None, 0.0, 0.0, 2e-6]
