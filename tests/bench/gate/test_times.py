"""Times and instructions: the order of blocks, the core, the deadline, and what is measured once more."""

import random
from contextlib import AbstractContextManager
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

from bench.gate import run
from bench.gate.record import GateCell, GateRecord, GateSettings, controls
from bench.gate.side import Died
from bench.gate.trees import BASE, HEAD, SourceTree
from bench.gate.verdict import Outcome, verdict

SETTINGS = GateSettings(pairs=3, blocks=4)
BOTH = SourceTree(Path(BASE)), SourceTree(Path(HEAD))


class Recorded(AbstractContextManager[Any]):
    """A stand-in for a process: it writes down its orders and replies with a fixed time of its side."""

    blocks: list[tuple[str, str]]
    layouts: list[tuple[int, int]]
    cores: list[int | None]
    counted: list[str]
    dying = ""

    def __init__(
        self,
        tree: SourceTree,
        *,
        hash_seed: int,
        padding: int = 0,
        started: list[Any] | None = None,
        **_: Any,
    ) -> None:
        self.side, self.killed = tree.path.name, False
        self.layouts.append((hash_seed, padding))
        if started is not None:
            started.append(self)

    def kill(self) -> None:
        """End it: its next count says so."""
        self.killed = True

    def ask(self, do: str, cell: str = "", **arguments: Any) -> int:
        """Take an order; the side that is dying ends in its first count."""
        if do == "block":
            self.blocks.append((self.side, cell))
        elif do == "settle":
            self.cores.append(arguments["core"])
        elif do == "count":
            if self.side == self.dying:
                sleep(0.2)  # until the other side has begun
                raise Died(self.side, "an instruction that valgrind does not know")
            if self.killed:
                raise Died(self.side, "was ended")
            self.counted.append(cell)
            sleep(0.02)
        return 1000 if self.side == BASE else 1100

    def __exit__(self, *_: object) -> None:
        pass


@pytest.fixture(autouse=True)
def recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    Recorded.blocks, Recorded.layouts, Recorded.cores, Recorded.counted = [], [], [], []
    monkeypatch.setattr(run, "Side", Recorded)


def measure(seconds: float, settings: GateSettings = SETTINGS) -> tuple[bool, list[GateCell]]:
    """The control cells, measured, with so many seconds left."""
    cells, rng = controls(), random.Random(1)
    return run.measure(cells, BOTH, {"control": [[0.0]]}, settings, rng, monotonic() + seconds), cells


def test_pairs_are_of_both_sides_on_one_core_in_the_order_abba_and_no_two_have_one_layout() -> None:
    done, cells = measure(60)
    order = [side for side, cell in Recorded.blocks if cell == "control:loop:-"]
    assert order[:8] == [BASE, HEAD, HEAD, BASE, BASE, HEAD, HEAD, BASE]
    assert done
    assert all(cell.pairs == [[(1000, 1100)] * SETTINGS.blocks] * SETTINGS.pairs for cell in cells)
    assert len(set(Recorded.cores)) == 1
    assert len(set(Recorded.layouts)) == 2 * SETTINGS.pairs


def test_neither_side_goes_first_more_often_where_the_number_of_blocks_is_odd() -> None:
    measure(60, GateSettings(pairs=2, blocks=5))
    firsts = [side for side, cell in Recorded.blocks if cell == "control:loop:-"][::2]
    assert firsts.count(BASE) == firsts.count(HEAD) == 5


def test_no_pair_is_begun_after_the_deadline() -> None:
    done, cells = measure(-1)
    assert not done
    assert [cell.pairs for cell in cells] == [[], []]


@pytest.mark.parametrize("dying", [BASE, HEAD])
def test_counting_stops_on_both_sides_when_one_side_dies(dying: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Recorded, "dying", dying)
    cells = [GateCell(vehicle="control", method=str(i)) for i in range(100)]
    with pytest.raises(Died):
        run.count(cells, BOTH, {"control": [[0.0]]}, hash_seed=0)
    assert len(Recorded.counted) < len(cells) / 2


@pytest.mark.parametrize(
    ("moved", "attempts", "outcome", "says"),
    [
        ([1.1, 1.0, 1.0], 2, Outcome.PASS, "pass"),
        (
            [1.1] * 9,
            run.ATTEMPTS,
            Outcome.INCONCLUSIVE,
            "no answer got worse; inconclusive about time: cells",
        ),
    ],
    ids=["once", "always"],
)
def test_times_are_taken_again_where_cells_that_no_commit_can_change_say_that_the_machine_moved(
    monkeypatch: pytest.MonkeyPatch, moved: list[float], attempts: int, outcome: Outcome, says: str
) -> None:
    """A control cell moves by ``moved[i]`` in attempt i; where it always does, times stay open."""
    cells = [GateCell(vehicle=name, method="loop", calls=10) for name in ("control", "ukwial")]
    ratios = iter(moved)

    def time_all(cells: list[GateCell], *_: object) -> bool:
        ratio = next(ratios)
        for c in cells:
            head = round(1000 * ratio) if c.is_control else 1000
            c.pairs += [[(1000, head + i)] for i in range(SETTINGS.pairs)]
        return True

    monkeypatch.setattr(run, "calibrate", lambda *_: None)
    monkeypatch.setattr(run, "measure", time_all)
    monkeypatch.setattr(run, "_answers", lambda record, *_: record.cells.extend(cells) or {})
    record = GateRecord(base="a", head="b", settings=SETTINGS)
    run.compare(record, BOTH, (), count=False)
    assert len(moved) - len(list(ratios)) == attempts
    assert [len(cell.pairs) for cell in record.cells] == [SETTINGS.pairs] * 2
    assert verdict(record).outcome is outcome
    assert verdict(record).summary.startswith(says)
