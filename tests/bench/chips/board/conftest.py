"""Logs that small projects printed on this computer."""

from pathlib import Path

import pytest

from alloc import load_vehicle
from bench.chips.board.files import write
from bench.chips.board.heard import Heard, boards
from bench.chips.board.project import plan
from bench.inputs.board_log import read_board_log
from tests.board_projects import SETS, Hear, make, project


@pytest.fixture(scope="session")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """What a small project printed on this computer: every demand timed 150 times."""
    folder = tmp_path_factory.mktemp("project")
    write(project(), folder)
    make(folder, "log", "CFLAGS=-O1 -DBOARD_PASSES=150")
    return (folder / "build/posix/LOG").read_bytes()


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """What a project with a rule of practice and the exact method printed on this computer."""
    folder = tmp_path_factory.mktemp("rules")
    asked = ("clip@native", "nullspace@native")
    write(plan(load_vehicle("bluerov2-heavy"), asked, (*SETS, "boundary"), "double", "fixed", 8, 3), folder)
    make(folder, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    return (folder / "build/posix/LOG").read_bytes()


@pytest.fixture(scope="session")
def leveled(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """What a project with `priority`, which has levels, printed on this computer."""
    folder = tmp_path_factory.mktemp("levels")
    methods = ("priority@native", "clip@native")
    write(plan(load_vehicle("bluerov2-heavy"), methods, SETS[1:], "double", "fixed", 8, 3), folder)
    make(folder, "log", "CFLAGS=-O1 -DBOARD_PASSES=2")
    return (folder / "build/posix/LOG").read_bytes()


@pytest.fixture
def hear(tmp_path: Path) -> Hear:
    def boards_in(text: bytes) -> list[Heard]:
        path = tmp_path / "LOG"
        path.write_bytes(text)
        return boards(path, read_board_log(path))

    return boards_in
