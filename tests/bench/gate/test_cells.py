"""Cells that a pattern chooses."""

import pytest

from alloc.errors import UnknownName
from bench.gate.record import matching_cells, refuse_pattern, restrict_patterns


def test_patterns_choose_cells_with_and_without_the_start() -> None:
    cells = [["ukwial", "pinv", "-"], ["ukwial", "qp/daqp", "warm"], ["nautilus", "pinv", "-"]]
    assert [c.name for c in matching_cells(cells, ["ukwial:pinv"])] == ["ukwial:pinv:-"]
    assert [c.name for c in matching_cells(cells, ["*:qp/*:warm", "naut*"])] == [
        "ukwial:qp/daqp:warm",
        "nautilus:pinv:-",
    ]


def test_patterns_are_for_the_vehicles_that_are_named_beside_them() -> None:
    """A star took the shipped vehicles too, and one of them failed the gate of a plug-in for another."""
    cells = [[vehicle, "mine", "-"] for vehicle in ("ukwial", "nautilus", "my[rov].yaml")]
    for pattern in ("*:mine", "*", "my*:mine:*"):
        mine = restrict_patterns(["my[rov].yaml"], [pattern])
        assert [c.vehicle for c in matching_cells(cells, mine)] == ["my[rov].yaml"]
    with pytest.raises(
        UnknownName, match=r"--cells ukwial:mine: is for none of --vehicle a.yaml --vehicle b"
    ):
        restrict_patterns(["a.yaml", "b.yaml"], ["ukwial:mine"])


@pytest.mark.parametrize(
    ("pattern", "named"),
    [
        ("*:plain:cold", "ukwial:plain:-, nautilus:plain:-"),
        ("ukwial:qp/daqp:hot", "ukwial:qp/daqp:warm, ukwial:qp/daqp:cold"),
        ("tiburon:plain", "ukwial:plain:-, nautilus:plain:-"),
        ("plain", "ukwial:plain:-, nautilus:plain:-"),
        ("ukwial:plane", "ukwial:plain:-"),
        ("nautilus:magic", "nautilus:plain:-"),
        ("tiburon:magic", "ukwial:plain:-, ukwial:qp/daqp:warm, ukwial:qp/daqp:cold, nautilus:plain:-"),
    ],
)
def test_a_pattern_that_fits_nothing_is_told_the_cells_that_there_are_instead(
    pattern: str, named: str
) -> None:
    """'*:plain:cold' was told to be vehicle:method:start, which it was; plain has no start but '-'."""
    cells = [
        ["ukwial", "plain", "-"],
        ["ukwial", "qp/daqp", "warm"],
        ["ukwial", "qp/daqp", "cold"],
        ["nautilus", "plain", "-"],
    ]
    assert (
        refuse_pattern([*cells, *cells], pattern)
        == f"no cell of either side fits {pattern}; there are {named}"
    )
    many = [["ukwial", f"m{i}", "-"] for i in range(20)]
    assert refuse_pattern(many, "ukwial:*:cold").endswith("ukwial:m7:- and 12 more")
