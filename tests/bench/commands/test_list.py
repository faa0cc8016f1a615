"""Every name that `thrustbench list` prints can be typed as an argument."""

import pytest
from click.testing import CliRunner

from alloc import catalogue, list_vehicles
from bench.chips.boards import boards
from bench.chips.processors import names
from bench.commands.list import command
from bench.demands import list_demands


def test_in_80_columns_words_stand_under_names_and_no_line_is_longer() -> None:
    done = CliRunner().invoke(command, env={"COLUMNS": "80", "TERM": "dumb"})
    lines = done.output.splitlines()
    assert max(map(len, lines)) <= 80
    place = next(i for i, line in enumerate(lines) if line.startswith("nullspace "))
    assert lines[place + 1].startswith("    Exact optimum of eq. 4-5")
    assert len(lines) < 2.9 * len(catalogue())  # a table of four columns took twice as many


@pytest.mark.parametrize("columns", ["80", "120", "160"])
def test_every_name_stands_whole_also_in_a_narrow_window(columns: str) -> None:
    done = CliRunner().invoke(command, env={"COLUMNS": columns, "TERM": "dumb"})
    assert done.exit_code == 0
    words = set(done.output.replace(",", " ").split())
    assert {entry.name for entry in catalogue()} | set(list_vehicles()) | set(list_demands()) <= words
    assert {board.name for name in names() for board in boards(name)} <= words
