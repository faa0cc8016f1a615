"""Paired time: fresh base and head processes on one core, blocks in ABBA order, the CPU clock."""

import random
from collections.abc import Sequence
from contextlib import ExitStack
from time import monotonic

from bench.gate.cells import Demands, load
from bench.gate.record import GateCell, GateSettings
from bench.gate.side import Side, SourceTree
from bench.harness import machine

PADDING = 4096
"""Most bytes of environment that are added: they move the stack through one page, as another shell would."""


def calibrate(cells: Sequence[GateCell], base: SourceTree, demands: Demands, settings: GateSettings) -> None:
    """Choose each cell's rounds so that a block takes ``settings.block_ms`` on the base."""
    with _ready(base, cells, demands, random.Random(settings.seed)) as side:
        for cell in cells:
            once = min(_block(side, cell, rounds=1) for _ in range(3))
            cell.rounds = max(1, round(settings.block_ms * 1e6 / once))
            cell.calls = cell.rounds * len(demands[cell.vehicle])


def measure(
    cells: Sequence[GateCell],
    trees: tuple[SourceTree, SourceTree],
    demands: Demands,
    settings: GateSettings,
    rng: random.Random,
    deadline: float,
) -> bool:
    """Add ``settings.pairs`` pairs to each cell; False if the deadline came first.

    A pair that runs when the deadline comes is finished, so all cells have equally many pairs.
    """
    core = machine.core()
    for pair in range(settings.pairs):
        if monotonic() > deadline:
            return False
        with ExitStack() as stack:
            base, head = (stack.enter_context(_ready(tree, cells, demands, rng, core)) for tree in trees)
            for cell in cells:
                cell.pairs.append([])
            for block in range(settings.blocks):
                for cell in rng.sample(list(cells), len(cells)):
                    # The order ABBA lets a drift over two blocks hit both sides alike. Where the number of
                    # blocks is odd, the next pair starts with the other side.
                    order = (base, head) if (pair + block) % 2 == 0 else (head, base)
                    times = {side: _block(side, cell, cell.rounds) for side in order}
                    cell.pairs[-1].append((times[base], times[head]))
    return True


def _block(side: Side, cell: GateCell, rounds: int) -> int:
    """CPU time [ns] of ``rounds`` times round the demands of a cell's vehicle."""
    return int(side.ask("block", cell=cell.name, vehicle=cell.vehicle, rounds=rounds))


def _ready(
    tree: SourceTree, cells: Sequence[GateCell], demands: Demands, rng: random.Random, core: int | None = None
) -> Side:
    side = Side(tree, hash_seed=rng.randrange(2**32), padding=rng.randrange(PADDING))
    try:
        load(side, cells, demands, core)
    except BaseException:
        side.close()
        raise
    return side
