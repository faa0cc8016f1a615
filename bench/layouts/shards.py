"""Shards: the numbers of some thousand layouts as one Parquet file, named by what is in it."""

import hashlib
import json
import re
from functools import lru_cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from alloc import AllocError
from alloc.errors import NotInstalled
from alloc.files.textfile import write_bytes
from bench.layouts.measure import COUNTS, measure
from bench.layouts.memory import keep_freed_memory
from bench.layouts.sampling import ShardTask, values
from bench.layouts.space import LayoutSpace

if TYPE_CHECKING:
    import pyarrow as pa

NAME = re.compile(r"(\d+)-(\d+)-([0-9a-f]{16})\.parquet")
"""Round, piece, and the first digits of the SHA-256 of the file's bytes."""

FACTS = b"thrustbench"
"""Where a shard says how many layouts it was asked for, and why some have no row."""


class OtherVersion(AllocError):
    """A worker has another version of this code, so that its numbers could differ."""


def compute(space: LayoutSpace, task: ShardTask, source: str) -> bytes:
    """The Parquet file of a task's layouts; ``source`` is the caller's ``source_digest``.

    The same task gives the same bytes, whoever works it out, on processors of one kind.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    if source != source_digest():
        raise OtherVersion("has another version of thrustbench; install the same there")
    keep_freed_memory()
    parameters = values(space, task)
    counted = measure(space, parameters)
    columns = {
        "round": pa.array(np.full(len(counted.kept), task.round, dtype=np.int16)),
        "layout": pa.array(task.first + counted.kept),
    }
    for parameter, column in zip(space.parameters, parameters, strict=True):
        columns[parameter.name] = pa.array(column[counted.kept])
    for name, numbers in counted.columns.items():
        kind = pa.int16() if name in COUNTS else pa.float64()
        columns[name] = pa.array(np.asarray(numbers), from_pandas=True).cast(kind)  # NaN becomes null
    facts = json.dumps({"asked": task.count, "refused": counted.refused}, sort_keys=True)
    table = pa.table(columns).replace_schema_metadata({FACTS: facts})
    buffer = BytesIO()
    pq.write_table(table, buffer, compression="zstd")
    return buffer.getvalue()


def check_installed() -> None:
    """Raise NotInstalled where a package that makes shards is missing."""
    for package in ("pyarrow", "distributed"):
        if find_spec(package) is None:
            raise NotInstalled(f"{package} is not installed; pip install 'thrustbench[layouts]'")


@lru_cache(maxsize=1)
def source_digest() -> str:
    """A name for the code that makes the numbers: equal where it is equal."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def file_name(round_: int, index: int, data: bytes) -> str:
    """The name of a shard with these bytes."""
    return f"{round_}-{index:06d}-{hashlib.sha256(data).hexdigest()[:16]}.parquet"


def keep(folder: Path, task: ShardTask, data: bytes) -> Path:
    """Write a shard whole, or not at all."""
    path = folder / file_name(task.round, task.index, data)
    write_bytes(path, data, "make room and go on with --resume, or give another --out")
    return path


def whole_shards(folder: Path) -> dict[tuple[int, int], Path]:
    """The shards of a folder by round and piece; a file that is not what its name says is removed."""
    found = {}
    for path in sorted(folder.iterdir()):
        named = NAME.match(path.name.removeprefix("."))  # a kill while writing leaves a file with a dot
        if named and path.name == file_name(int(named[1]), int(named[2]), path.read_bytes()):
            found[int(named[1]), int(named[2])] = path
        elif named:
            path.unlink()
    return found


def read_shard(path: Path, columns: list[str] | None = None) -> "pa.Table":
    """The rows of a shard."""
    import pyarrow.parquet as pq

    return pq.ParquetFile(path).read(columns=columns, use_threads=False)


class ShardFacts(NamedTuple):
    """What a shard says besides its rows.

    Attributes
    ----------
    asked : how many layouts it was asked for
    refused : how many have no row, by constraint, or ``rank``
    """

    asked: int
    refused: dict[str, int]


def facts_of(path: Path) -> ShardFacts:
    """What a shard says besides its rows."""
    import pyarrow.parquet as pq

    return ShardFacts(**json.loads(pq.ParquetFile(path).schema_arrow.metadata[FACTS]))
