"""Every name that `thrustbench list` prints can be typed as an argument."""

import pytest
from click.testing import CliRunner

from alloc import catalogue, list_vehicles
from bench.commands.list import command
from bench.demands import list_demands


@pytest.mark.parametrize("columns", ["80", "120"])
def test_every_name_stands_whole_also_in_a_narrow_window(columns: str) -> None:
    done = CliRunner().invoke(command, env={"COLUMNS": columns, "TERM": "dumb"})
    assert done.exit_code == 0
    words = set(done.output.replace(",", " ").split())
    assert {entry.name for entry in catalogue()} | set(list_vehicles()) | set(list_demands()) <= words
