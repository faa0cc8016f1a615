"""Measurement of pairs: the order of blocks, the core, the deadline."""

import random
from time import monotonic
from typing import Any

import pytest

from bench.gate import run
from bench.gate.record import GateSettings, controls
from bench.gate.trees import BASE, HEAD, SourceTree

SETTINGS = GateSettings(pairs=3, blocks=4)


class Recorded:
    """A stand-in for a process: it writes down its orders and replies with a fixed time of its side."""

    blocks: list[tuple[str, str]]
    layouts: list[tuple[int, int]]
    cores: list[int | None]

    def __init__(self, tree: SourceTree, *, hash_seed: int, padding: int) -> None:
        self.side = tree.path.name
        self.layouts.append((hash_seed, padding))

    def ask(self, do: str, **arguments: Any) -> int:
        """Take an order."""
        if do == "block":
            self.blocks.append((self.side, arguments["cell"]))
        elif do == "settle":
            self.cores.append(arguments["core"])
        return 1000 if self.side == BASE else 1100

    def __enter__(self) -> "Recorded":
        return self

    def __exit__(self, *_: object) -> None:
        pass


@pytest.fixture
def both(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> tuple[SourceTree, SourceTree]:
    Recorded.blocks, Recorded.layouts, Recorded.cores = [], [], []
    monkeypatch.setattr(run, "Side", Recorded)
    return SourceTree(tmp_path / BASE), SourceTree(tmp_path / HEAD)


def measure(both: tuple[SourceTree, SourceTree], deadline: float) -> tuple[bool, Any]:
    cells = controls()
    demands = {"control": [[0.0]]}
    return run.measure(cells, both, demands, SETTINGS, random.Random(1), deadline), cells


def test_blocks_of_a_cell_come_in_the_order_abba(both: tuple[SourceTree, SourceTree]) -> None:
    measure(both, monotonic() + 60)
    order = [side for side, cell in Recorded.blocks if cell == "control:loop:-"]
    assert order[:8] == [BASE, HEAD, HEAD, BASE, BASE, HEAD, HEAD, BASE]


def test_neither_side_goes_first_more_often_where_the_number_of_blocks_is_odd(
    both: tuple[SourceTree, SourceTree],
) -> None:
    settings = GateSettings(pairs=2, blocks=5)
    run.measure(controls(), both, {"control": [[0.0]]}, settings, random.Random(1), monotonic() + 60)
    firsts = [side for side, cell in Recorded.blocks if cell == "control:loop:-"][::2]
    assert firsts.count(BASE) == firsts.count(HEAD) == 5


def test_each_block_is_kept_as_the_times_of_base_and_head(both: tuple[SourceTree, SourceTree]) -> None:
    done, cells = measure(both, monotonic() + 60)
    assert done
    for cell in cells:
        assert cell.pairs == [[(1000, 1100)] * SETTINGS.blocks] * SETTINGS.pairs


def test_all_processes_run_on_one_core_and_no_two_have_the_same_layout(
    both: tuple[SourceTree, SourceTree],
) -> None:
    measure(both, monotonic() + 60)
    assert len(set(Recorded.cores)) == 1
    assert len(set(Recorded.layouts)) == 2 * SETTINGS.pairs


def test_no_pair_is_begun_after_the_deadline(both: tuple[SourceTree, SourceTree]) -> None:
    done, cells = measure(both, monotonic() - 1)
    assert not done
    assert [cell.pairs for cell in cells] == [[], []]
