"""Logs that small projects printed on this computer."""

from pathlib import Path

import pytest

from alloc import load_vehicle
from bench.chips.board.log import Heard, boards
from bench.chips.board.project import plan
from bench.inputs.board_log import read_board_log
from tests.board_projects import SETS, Hear, printed, project


@pytest.fixture(scope="session")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Output of a small project on this computer: every demand timed 150 times."""
    return printed(tmp_path_factory.mktemp("project"), project(), 150)


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Output of a project with a rule of practice and the exact method on this computer."""
    methods = ("clip@native", "nullspace@native")
    made = plan(load_vehicle("bluerov2-heavy"), methods, (*SETS, "boundary"), "double", "fixed", 8, 3)
    return printed(tmp_path_factory.mktemp("rules"), made, 1)


@pytest.fixture(scope="session")
def leveled(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Output of a project with `priority`, which has levels, on this computer."""
    methods = ("priority@native", "clip@native")
    made = plan(load_vehicle("bluerov2-heavy"), methods, SETS[1:], "double", "fixed", 8, 3)
    return printed(tmp_path_factory.mktemp("levels"), made, 2)


@pytest.fixture
def hear(tmp_path: Path) -> Hear:
    def boards_in(text: bytes) -> list[Heard]:
        path = tmp_path / "LOG"
        path.write_bytes(text)
        return boards(path, read_board_log(path))

    return boards_in
