"""Blocks of a board's log: thrusts, statuses and ticks of answers, and counted times."""

from collections import Counter
from typing import Any, NamedTuple

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from bench.inputs.board_log import COUNTER, LogBlock, LogError, whole


class Answered(NamedTuple):
    """The answers of a block of kind ask, N of them.

    Attributes
    ----------
    F : (N, n) thrusts as the kernel left them [N]
    status : (N,) what it returned
    ticks : (N,) of the first pass
    stack_bytes : (N,) that the kernel wrote to, 0 where the driver was not built to look at it
    shares : (N, levels) what it says that it delivered of each level [-]
    """

    F: FloatArray
    status: IndexArray
    ticks: IndexArray
    stack_bytes: IndexArray
    shares: FloatArray


def answered(block: LogBlock, n: int, scalar: np.dtype[Any], levels: int = 0) -> Answered:
    """The answers of a block of kind ask, of n thrusters; raises LogError where its lines hold others."""
    values = n + levels
    hexes = values * (2 * scalar.itemsize + 1) - 1
    texts = block.texts("f")
    try:
        # A log may hold a million of these lines, so they are taken apart by columns.
        if texts and texts[0].count(b" ") > 2 + values:
            both = [text.rpartition(b" ") for text in texts]
            rests, stack = [one[0] for one in both], np.array([int(one[2]) for one in both], dtype=np.intp)
        else:
            rests, stack = texts, np.zeros(len(texts), dtype=np.intp)
        counts = b" ".join([rest[: -hexes - 1] for rest in rests]).split()
        digits = np.array(counts, dtype="S11")  # one more than a driver's counters have
        number, status, ticks = digits.astype(np.int64).reshape(len(texts), 3).T
        if min(number.min(), status.min(), ticks.min()) < 0 or max(status.max(), ticks.max()) > COUNTER:
            raise ValueError("counts that no driver prints")
        bits = bytes.fromhex(b" ".join([rest[-hexes:] for rest in rests]).decode("ascii"))
        found = np.frombuffer(bits, scalar.newbyteorder(">")).reshape(len(texts), values).astype(np.float64)
    except (ValueError, IndexError, OverflowError):
        raise LogError(_FOREIGN.format(" ".join(block.words))) from None
    if not np.array_equal(number, np.arange(len(found))):
        raise LogError(_FOREIGN.format(" ".join(block.words)))
    status = status.astype(np.uint32).astype(np.int32)  # two's complement
    return Answered(found[:, :n], status.astype(np.intp), ticks, stack, found[:, n:])


_FOREIGN = "{}: lines of another driver; take the project's own"


def seen(block: LogBlock, kind: str) -> list[tuple[int, int]]:
    """Ticks and how often they were seen, of a block's lines of that kind, sorted."""
    times: Counter[int] = Counter()
    numbers = [whole(word.decode("ascii", "replace")) for word in b" ".join(block.texts(kind)).split()]
    for ticks, often in zip(numbers[::2], numbers[1::2], strict=True):
        times[ticks] += often
    return sorted(times.items())
