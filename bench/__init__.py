"""The harness: runs every method in its own process, times it, judges it, reports it.

A script reads a run through ``load_run``, or its rows alone through ``load``. Both import what they need only
when they are called, because every command imports this package and ``--help`` must not wait for numpy.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from bench.results.columns import Row
    from bench.results.rows import Run

__all__ = ["Row", "Run", "load", "load_run"]


def load_run(directory: "str | Path") -> "Run":
    """The run in a folder: its rows, when and how it was made, the machine, and the times as they were taken.

    Raises RecordError, an ``alloc.AllocError``, where the folder holds no readable record.
    """
    from pathlib import Path

    from bench.results.rows import read_run

    return read_run(Path(directory))


def load(directory: "str | Path") -> "tuple[Row, ...]":
    """The rows of the run in a folder, as they stand in its results.csv; empty where nothing was timed.

    Raises RecordError, an ``alloc.AllocError``, where the folder holds no readable record.
    """
    return load_run(directory).rows


if not TYPE_CHECKING:  # with this function a type checker would accept any name; it has both from above

    def __getattr__(name: str) -> type:
        if name not in ("Row", "Run"):
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from bench.results import columns, rows

        return columns.Row if name == "Row" else rows.Run
