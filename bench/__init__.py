"""The harness: runs every method in its own process, times it, judges it, reports it.

A script reads a run through ``load``. ``load`` imports what it needs only when it is called, because every
command imports this package and ``--help`` must not wait for numpy.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from bench.results.columns import Row

__all__ = ["Row", "load"]


def load(directory: "str | Path") -> "tuple[Row, ...]":
    """The rows of the run in a folder, as they stand in its results.csv; empty where nothing was timed.

    Raises RecordError, an ``alloc.AllocError``, where the folder holds no readable record.
    """
    from pathlib import Path

    from bench.results.rows import read_run

    return read_run(Path(directory)).rows


if not TYPE_CHECKING:  # with this function a type checker would accept any name; it has Row from above

    def __getattr__(name: str) -> type:
        if name != "Row":
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from bench.results.columns import Row

        return Row
