"""Times are taken again where cells that no commit can change say that the machine moved."""

from pathlib import Path

import pytest

from bench.gate import run
from bench.gate.record import GateCell, GateRecord, GateSettings
from bench.gate.trees import SourceTree
from bench.gate.verdict import Outcome, verdict

SETTINGS = GateSettings(pairs=4)
BOTH = SourceTree(Path("base")), SourceTree(Path("head"))


def gate(monkeypatch: pytest.MonkeyPatch, *moved: float) -> tuple[GateRecord, int]:
    """A gate of one cell; attempt i at timing sees the control cell move by ``moved[i]``, and how many."""
    cell, control = (
        GateCell(vehicle="ukwial", method="mine", calls=10),
        GateCell(vehicle="control", method="loop", calls=10),
    )
    attempts = iter(moved)

    def measure(cells: list[GateCell], *_: object) -> bool:
        ratio = next(attempts)
        for c in cells:
            head = round(1000 * ratio) if c.is_control else 1000
            c.pairs += [[(1000, head + i)] for i in range(SETTINGS.pairs)]
        return True

    monkeypatch.setattr(run, "calibrate", lambda *_: None)
    monkeypatch.setattr(run, "measure", measure)
    monkeypatch.setattr(run, "_answers", lambda record, *_: record.cells.extend([control, cell]) or {})
    record = GateRecord(base="a", head="b", settings=SETTINGS)
    run.compare(record, BOTH, (), count=False)
    return record, len(moved) - len(list(attempts))


def test_a_machine_that_moved_once_is_given_another_try(monkeypatch: pytest.MonkeyPatch) -> None:
    record, attempts = gate(monkeypatch, 1.1, 1.0, 1.0)
    assert verdict(record).outcome is Outcome.PASS
    assert attempts == 2
    assert [len(cell.pairs) for cell in record.cells] == [SETTINGS.pairs] * 2


def test_a_machine_that_never_is_still_leaves_times_open_and_answers_passed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    record, attempts = gate(monkeypatch, *[1.1] * 9)
    result = verdict(record)
    assert attempts == run.ATTEMPTS
    assert result.outcome is Outcome.INCONCLUSIVE
    assert result.summary.startswith("no answer got worse; inconclusive about time: cells that no commit")
