"""The study of repeated runs, without the runs."""

from collections.abc import Iterator
from pathlib import Path

import pytest

import repeats

SAME = [("scaled", False)] * 10
TOLD = [("scaled", True)] * 9 + [("clip", True)]
UNTOLD = [("scaled", True)] * 9 + [("clip", False)]


@pytest.mark.parametrize(
    ("choices", "code", "line"),
    [
        (SAME, 0, "v: 10 × scaled\n"),
        (TOLD, 0, "v: 9 × scaled, open; 1 × clip, open\n"),
        (UNTOLD, 1, "v: 9 × scaled, open; 1 × clip\n"),
    ],
)
def test_two_first_choices_are_a_failure_where_one_run_does_not_say_so(
    choices: list[tuple[str, bool]],
    code: int,
    line: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    made: Iterator[tuple[str, bool]] = iter(choices)
    folders: list[Path] = []

    def first_choice(vehicle: str, folder: Path) -> tuple[str, bool]:
        folders.append(folder)
        return next(made)

    monkeypatch.setattr(repeats, "first_choice", first_choice)
    assert repeats.main(["v"]) == code
    assert capsys.readouterr().out == line
    assert len(set(folders)) == repeats.REPEATS  # each run is a new one
