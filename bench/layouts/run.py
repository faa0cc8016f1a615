"""Parent process of a study: hand shards to workers, keep results, refine around the best."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from filelock import FileLock, Timeout
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from alloc import AllocError
from alloc.errors import FileError
from alloc.files.textfile import write_text
from bench.layouts.measure import refused
from bench.layouts.shards import ShardTask, keep, read_shard, tasks, values, whole_shards
from bench.layouts.space import LayoutSpace, combinations_of_grid, poses
from bench.layouts.study import MOST, StudyDocument, StudyFile
from bench.layouts.summary import merged, spread

if TYPE_CHECKING:
    import pyarrow as pa

AROUND = 64
"""Best layouts that a round of refinement draws around."""

SHARDS, IDENTITY = "shards", "study.json"

Compute = Callable[[Sequence[ShardTask]], Iterator[tuple[ShardTask, bytes]]]
"""Works out the shards of tasks, in any order."""


class LayoutError(AllocError):
    """A study's folder holds another study, or its constraints leave no layout."""


@dataclass(frozen=True)
class Done:
    """Progress of a study.

    Attributes
    ----------
    layouts, total : worked out so far, refused ones included, and how many there will be
    computed : of them by this call, not by an earlier one
    """

    layouts: int
    total: int
    computed: int


def count_layouts(document: StudyDocument, space: LayoutSpace, n: int | None) -> int:
    """Number of layouts of a study: ``n`` where it is given, else the file's, or all of a grid."""
    if document.keys.sampling == "sobol":
        return n or document.keys.n
    count = combinations_of_grid(space)
    if n is not None and n != count:
        raise LayoutError(
            f"--n {n}: a grid has all its {count:,} layouts; leave --n out, or write sampling: sobol"
        )
    if count > MOST:
        raise document.refusal(
            "sampling", f"the grid has {count:,} layouts; take fewer steps, at most {MOST:,}"
        )
    return count


def check_folder(folder: Path, space: LayoutSpace, keys: StudyFile, n: int, *, resume: bool) -> None:
    """Raise LayoutError where a folder holds another study, or this one and ``resume`` is not given."""
    if folder.exists() and not folder.is_dir():
        raise FileError("can't be written (not a directory); give another --out", path=folder)
    path, shards = folder / IDENTITY, folder / SHARDS
    started = shards.is_dir() and any(shards.iterdir())
    if path.is_file():
        if path.read_text(encoding="utf-8") != identity(space, keys, n):
            raise LayoutError(f"{path}: another study, base, --n or seed was asked here; give another --out")
        if started and not resume:
            raise LayoutError(
                f"{folder}: holds shards of this study; go on with --resume, or give another --out"
            )
    elif started:
        raise LayoutError(f"{folder}: holds shards, but not what was asked for; give another --out")


def run_study(
    space: LayoutSpace,
    keys: StudyFile,
    n: int,
    folder: Path,
    compute: Compute,
    *,
    resume: bool,
    watch: Callable[[Done], None],
) -> None:
    """Work out all shards of a study into ``folder/shards``; with ``resume``, those that are missing.

    Raises LayoutError as ``check_folder`` does, and FileError where the folder can't be written.
    """
    try:
        (folder / SHARDS).mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / ".lock")
        lock.acquire(timeout=0)
    except Timeout:
        raise LayoutError(f"{folder}: another study writes here; wait for it or give another --out") from None
    except OSError as error:
        raise FileError(f"can't be written ({error.strerror}); give another --out", path=folder) from None
    with lock:
        check_folder(folder, space, keys, n, resume=resume)
        write_text(folder / IDENTITY, identity(space, keys, n))
        _rounds(space, keys, n, folder / SHARDS, compute, watch)


def _rounds(
    space: LayoutSpace, keys: StudyFile, n: int, shards: Path, compute: Compute, watch: Callable[[Done], None]
) -> None:
    rounds = keys.refine.rounds
    done = Done(0, n + rounds * keys.refine.n, 0)
    planned = tasks(0, n, keys.sampling, keys.seed)
    for number in range(rounds + 1):
        done = _round(planned, shards, compute, done, watch)
        if number < rounds:
            best = spread(pareto_front(shards), AROUND)
            if not best.num_rows:
                break
            around = [
                parameter.share(best[parameter.name].to_numpy().astype(float))
                for parameter in space.parameters
            ]
            width = keys.refine.width / 2**number
            planned = tasks(
                number + 1,
                keys.refine.n,
                "sobol",
                keys.seed,
                tuple(map(tuple, np.array(around).T.tolist())),
                width,
            )


def _round(
    planned: Sequence[ShardTask], shards: Path, compute: Compute, done: Done, watch: Callable[[Done], None]
) -> Done:
    """Work out the shards of a round that are missing, and check that layouts are left by the constraints."""
    there = whole_shards(shards)
    missing = [task for task in planned if (task.round, task.index) not in there]
    had = sum(task.count for task in planned) - sum(task.count for task in missing)
    done = replace(done, layouts=done.layouts + had)
    watch(done)
    for task, data in compute(missing):
        keep(shards, task, data)
        done = Done(done.layouts + task.count, done.total, done.computed + task.count)
        watch(done)
    return done


def check_constraints(space: LayoutSpace, keys: StudyFile, n: int) -> None:
    """Raise LayoutError where none of a study's first layouts keeps to its constraints."""
    first = tasks(0, n, keys.sampling, keys.seed)[0]
    broken: dict[str, int] = {}
    for group in poses(space, values(space, first)):
        left = np.ones(len(group.which), dtype=bool)
        for reason, which in refused(group, space.constraints).items():
            broken[reason] = broken.get(reason, 0) + int(which.sum())
            left &= ~which
        if left.any():
            return
    most = max(broken, key=lambda reason: broken[reason]) if broken else "groups"
    where = f"constraints.{most}" if broken else most
    counts = ", ".join(f"{reason} {count:,}" for reason, count in sorted(broken.items()))
    raise LayoutError(
        f"{where}: none of the first {first.count:,} layouts is left ({counts or 'no thrusters'});"
        " loosen what refuses the most, or vary something else"
    )


def pareto_front(shards: Path) -> "pa.Table":
    """The Pareto front of all shards of a folder."""
    front = None
    for _, path in sorted(whole_shards(shards).items()):
        front = merged(front, read_shard(path))
    assert front is not None, "a round has shards"
    return front


def identity(space: LayoutSpace, keys: StudyFile, n: int) -> str:
    """All that decides the bytes of a study's shards, as JSON."""
    study, base = msgspec.to_builtins(keys), _plain(replace(space, notes=()))
    numbers = {"n": n, "study": study, "base": base}
    return msgspec.json.format(msgspec.json.encode(numbers, order="sorted")).decode() + "\n"


def _plain(space: LayoutSpace) -> dict[str, Any]:
    def plain(value: object) -> object:
        return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)

    made: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(space, enc_hook=plain))
    return made


@contextmanager
def bar(console: Console) -> Iterator[Callable[[Done], None]]:
    """A bar on the console, and the function that moves it; a line with the rate where it ends."""
    columns = (BarColumn(), TextColumn("{task.description}"), TimeRemainingColumn())
    began = time.monotonic()
    last = Done(0, 0, 0)
    with Progress(*columns, console=console, refresh_per_second=4) as shown:
        task = shown.add_task("starting")

        def watch(now: Done) -> None:
            nonlocal last
            last = now
            rate = now.computed / max(time.monotonic() - began, 1e-3)
            said = f"{now.layouts:,} of {now.total:,} layouts, {rate:,.0f} a second"
            shown.update(task, completed=now.layouts, total=now.total, description=said)

        yield watch
    seconds = time.monotonic() - began
    console.print(
        f"{last.computed:,} layouts in {seconds:.1f} s, {last.computed / max(seconds, 1e-3):,.0f} a second",
        highlight=False,
    )
