"""report.md: rendered from records alone, the same bytes each time."""

from pathlib import Path

import made_up
import pytest

from bench.report import render
from bench.report.text import table, three


def test_the_same_record_gives_the_same_bytes(tmp_path: Path) -> None:
    first = {path.name: path.read_bytes() for path in render(made_up.whole(tmp_path)).parent.iterdir()}
    render(tmp_path)
    assert first == {path.name: path.read_bytes() for path in tmp_path.iterdir()}


def test_what_failed_and_what_disagrees_is_named_with_its_reason(tmp_path: Path) -> None:
    text = render(made_up.whole(tmp_path)).read_text()
    assert "signal 11" in text
    assert "wrench missed by 3 N" in text


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (None, ""),
        (0.0, "0"),
        (1.2345, "1.23"),
        (9.999, "10.0"),
        (99.95, "100"),
        (0.012345, "0.0123"),
        (12345.6, "12300"),
        (1.5e-9, "1.50e-9"),
        (2.345e9, "2.34e9"),
        (float("inf"), "inf"),
    ],
)
def test_numbers_have_three_significant_digits(value: float | None, shown: str) -> None:
    assert three(value) == shown


def test_numbers_stand_right_and_words_left() -> None:
    text = table(("method", "t [µs]", "why"), [["pinv", "1.00", "yes"], ["svd", "", "no"]])
    ends = [(rule[0], rule[-1]) for rule in text.splitlines()[1].split("|")[1:4]]
    assert ends == [(":", "-"), ("-", ":"), (":", "-")]
