"""Instructions per call, counted by callgrind: exact where time is noisy, blind to memory latency.

One process a side counts all cells. It makes N and then 2 N calls of each cell. After each lot it calls
getppid, at which callgrind writes a profile and starts again from zero, so the difference of two profiles is
N calls and nothing else.
"""

import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from functools import cache
from pathlib import Path

from bench.gate.cells import Demands, load
from bench.gate.record import GateCell
from bench.gate.side import Side, SourceTree
from bench.harness.callgrind import CALLGRIND, totals

ROUNDS = 2
"""N calls go twice round the demands: counts repeat exactly, so more rounds would only take longer."""


@cache
def missing() -> str:
    """Why instructions can't be counted here, with the remedy; empty where they can."""
    if not shutil.which("valgrind"):
        return "no instruction counts, the gate rests on time alone: valgrind is missing, install it"
    return ""


def count(
    cells: Sequence[GateCell], trees: tuple[SourceTree, SourceTree], demands: Demands, hash_seed: int
) -> None:
    """Append (base, head) instructions per call to each cell; both sides are counted at once.

    Raises Refused or Died as a ``Side`` does, for instance where a library uses instructions that valgrind
    does not know.
    """
    started: list[Side] = []
    with ThreadPoolExecutor(2) as pool:
        counting = [pool.submit(_count, tree, cells, demands, hash_seed, started) for tree in trees]
        try:
            for side in wait(counting, return_when=FIRST_EXCEPTION).done:
                side.result()
        except BaseException:  # a side died, or Ctrl-C: the pool would wait a minute for the other side
            for running in started:
                running.kill()
            raise
    base, head = (side.result() for side in counting)
    for cell, *pair in zip(cells, base, head, strict=True):
        cell.instructions.append((pair[0], pair[1]))


def _count(
    tree: SourceTree, cells: Sequence[GateCell], demands: Demands, hash_seed: int, started: list[Side]
) -> list[float]:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "counts"
        options = (f"--callgrind-out-file={out}", "--dump-before=getppid")
        prefix = [*_fixed_addresses(), *CALLGRIND, *options]
        with Side(tree, hash_seed=hash_seed, prefix=prefix, started=started) as side:
            load(side, cells, demands, core=None)
            for cell in cells:
                side.ask("count", cell=cell.name, vehicle=cell.vehicle, rounds=ROUNDS)
        counted = totals(out)[-3 * len(cells) :]
    # Each cell has three profiles: everything before its calls, N calls, 2 N calls.
    calls = [ROUNDS * len(demands[cell.vehicle]) for cell in cells]
    return [(twice - once) / n for n, once, twice in zip(calls, counted[1::3], counted[2::3], strict=True)]


@cache
def _fixed_addresses() -> tuple[str, ...]:
    # Without address space randomisation counts repeat to the last digit; some containers forbid to
    # switch it off.
    setarch = shutil.which("setarch")
    if setarch and subprocess.run([setarch, "-R", "true"], capture_output=True).returncode == 0:
        return (setarch, "-R")
    return ()
