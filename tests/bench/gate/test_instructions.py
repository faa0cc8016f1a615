"""Counting instructions on both sides at once."""

from contextlib import AbstractContextManager
from pathlib import Path
from time import sleep
from typing import Any

import pytest

from bench.gate import run
from bench.gate.record import GateCell
from bench.gate.side import Died
from bench.gate.trees import SourceTree


@pytest.mark.parametrize("dead", ["base", "head"])
def test_counting_stops_on_both_sides_when_one_side_dies(
    dead: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted = []

    class Counting(AbstractContextManager[Any]):
        def __init__(self, tree: SourceTree, started: list[Any], **_: Any) -> None:
            self.name, self.killed = tree.path.name, False
            started.append(self)

        def kill(self) -> None:
            self.killed = True

        def ask(self, do: str, cell: str = "", **_: Any) -> None:
            if do == "count":
                if self.name == dead:
                    sleep(0.2)  # until the other side has begun
                    raise Died(dead, "an instruction that valgrind does not know")
                if self.killed:
                    raise Died(self.name, "was ended")
                counted.append(cell)
                sleep(0.02)

        def __exit__(self, *_: object) -> None:
            pass

    monkeypatch.setattr(run, "Side", Counting)
    cells = [GateCell(vehicle="control", method=str(i)) for i in range(100)]
    both = SourceTree(tmp_path / "base"), SourceTree(tmp_path / "head")
    with pytest.raises(Died):
        run.count(cells, both, {"control": [[0.0]]}, hash_seed=0)
    assert len(counted) < len(cells) / 2
