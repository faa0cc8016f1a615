"""Shards: sample some thousand layouts, compute their figures, keep them as one Parquet file."""

import ctypes
import hashlib
import json
import re
from functools import lru_cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np

from alloc import AllocError
from alloc.allocation import FloatArray
from alloc.errors import NotInstalled
from alloc.files.textfile import write_bytes
from bench.layouts.measure import NUMBERS, measure
from bench.layouts.space import LayoutSpace

if TYPE_CHECKING:
    import pyarrow as pa

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
LARGEST_MMAP_THRESHOLD = 32 << 20
"""glibc's bound; larger arrays than this are still given back at once."""


@lru_cache(maxsize=1)
def keep_freed_memory() -> bool:
    """Tell glibc to give memory back above 32 MB only; False where that is not possible.

    Dask starts its workers with a threshold of 64 kB, which costs half of a shard's time.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):  # another C library
        return False
    set_both = [mallopt(key, LARGEST_MMAP_THRESHOLD) for key in (M_TRIM_THRESHOLD, M_MMAP_THRESHOLD)]
    return all(set_both)


SHARD = 4096
"""Layouts of a shard: about a second's work, which is what a killed worker costs. A power of 2, as a Sobol'
sequence is even over such pieces."""


class ShardTask(msgspec.Struct, frozen=True, kw_only=True):
    """A piece of a round.

    Attributes
    ----------
    round : 0 for the study's own layouts, 1, 2, … for those around the best
    index : which piece of the round
    first, count : its layouts, counted within the round
    sampling : sobol or grid
    seed : of the round's sequence
    around : shares of the way of each parameter, for each of the best layouts
    width : of the piece of each span that is drawn from around those
    """

    round: int
    index: int
    first: int
    count: int
    sampling: str
    seed: int
    around: tuple[tuple[float, ...], ...] = ()
    width: float = 1.0


def tasks(
    round_: int,
    n: int,
    sampling: str,
    seed: int,
    around: tuple[tuple[float, ...], ...] = (),
    width: float = 1.0,
) -> list[ShardTask]:
    """The pieces of a round of n layouts."""
    return [
        ShardTask(
            round=round_,
            index=index,
            first=first,
            count=min(SHARD, n - first),
            sampling=sampling,
            seed=seed + round_,
            around=around,
            width=width,
        )
        for index, first in enumerate(range(0, n, SHARD))
    ]


def values(space: LayoutSpace, task: ShardTask) -> FloatArray:
    """(P, count) the parameters of a task's layouts; the same whoever asks."""
    if task.sampling == "grid" and not task.around:
        sides = [parameter.grid for parameter in space.parameters]
        number = np.arange(task.first, task.first + task.count)
        places = np.unravel_index(number, [len(side) for side in sides])
        return np.array([side[place] for side, place in zip(sides, places, strict=True)])
    share = _sobol(len(space.parameters), task).T
    if task.around:
        centre = np.array(task.around)[(task.first + np.arange(task.count)) % len(task.around)].T
        moved = np.clip(centre + (share - 0.5) * task.width, 0.0, 1.0)
        listed = np.array([bool(parameter.choices) for parameter in space.parameters])
        share = np.where(listed[:, None], centre, moved)  # choices from a list stay as they are
    return np.array([parameter.at(column) for parameter, column in zip(space.parameters, share, strict=True)])


def _sobol(parameters: int, task: ShardTask) -> FloatArray:
    from scipy.stats import qmc

    sequence = qmc.Sobol(parameters, scramble=True, rng=np.random.default_rng(task.seed))
    if task.first:  # SciPy refuses to go forward by nothing
        sequence.fast_forward(task.first)
    drawn: FloatArray = sequence.random(SHARD)[: task.count]  # a whole power of 2, as the sequence wants
    return drawn


NAME = re.compile(r"(\d+)-(\d+)-([0-9a-f]{16})\.parquet")
"""Round, piece, and the first digits of the SHA-256 of the file's bytes."""

FACTS = b"thrustbench"
"""Key under which a shard keeps how many layouts it was asked for, and why some have no row."""


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
        "round": pa.array(np.full(len(counted.places), task.round, dtype=np.int16)),
        "layout": pa.array(task.first + counted.places),
    }
    for parameter, column in zip(space.parameters, parameters, strict=True):
        columns[parameter.name] = pa.array(column[counted.places])
    for name, numbers in counted.columns.items():
        kind = pa.int16() if NUMBERS.get(name) is int else pa.float64()
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
    """Facts about a shard besides its rows.

    Attributes
    ----------
    asked : how many layouts it was asked for
    refused : how many have no row, by constraint, or ``rank``
    """

    asked: int
    refused: dict[str, int]


def shard_facts(path: Path) -> ShardFacts:
    """Facts about a shard besides its rows."""
    import pyarrow.parquet as pq

    return ShardFacts(**json.loads(pq.ParquetFile(path).schema_arrow.metadata[FACTS]))
