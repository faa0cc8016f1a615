"""The times of a row as they were taken, for statistics of a reader's own."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.results.columns import Row


class RowSamples(NamedTuple):
    """Times of all repeats of a row; B batches of calls, and S calls that were timed singly.

    Attributes
    ----------
    repeat : (B,) which repeat measured each batch, counted from 0
    calls : (B,) calls in each batch
    wall_ns, cpu_ns : (B,) time that each batch took, by the clock and of the thread's own CPU time [ns]
    single_ns : (S,) time of each single call [ns], sorted; records keep it in bins 2 % wide
    """

    repeat: NDArray[np.int64]
    calls: NDArray[np.int64]
    wall_ns: NDArray[np.int64]
    cpu_ns: NDArray[np.int64]
    single_ns: NDArray[np.int64]


def samples(row: Row) -> RowSamples:
    """Measured times of a row, before any statistics."""
    batches = [
        (i, b.calls, b.wall_ns, b.cpu_ns) for i, cell in enumerate(row.measured.cells) for b in cell.batches
    ]
    repeat, calls, wall_ns, cpu_ns = np.array(batches, np.int64).reshape(-1, 4).T
    times, counts = np.array(row.measured.singles, np.int64).reshape(-1, 2).T
    return RowSamples(repeat, calls, wall_ns, cpu_ns, np.repeat(times, counts))
