"""Which cells a pattern chooses."""

from bench.gate.cells import chosen


def test_patterns_choose_cells_with_and_without_the_start() -> None:
    cells = [["ukwial", "pinv", "-"], ["ukwial", "qp/daqp", "warm"], ["nautilus", "pinv", "-"]]
    assert [c.name for c in chosen(cells, ["ukwial:pinv"])] == ["ukwial:pinv:-"]
    assert [c.name for c in chosen(cells, ["*:qp/*:warm", "naut*"])] == [
        "ukwial:qp/daqp:warm",
        "nautilus:pinv:-",
    ]
