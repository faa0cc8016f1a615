"""Makes records of a log, one a board, and says what is in them and what was lost."""

from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from bench.chips.board.heard import NOOP, Heard, boards
from bench.chips.board.measured import lines
from bench.inputs.board_log import BoardLog, LogError, read_board_log
from bench.record import Cell, Emulated, Header
from bench.record.file import Writer
from bench.record.schema import slug
from bench.results.text import plural

SHOWN = 6
"""Most lost blocks that are named."""


class Kept(NamedTuple):
    """Result of ``keep``.

    Attributes
    ----------
    said : lines for whoever reads the log
    folders : of the records
    good : whether every answer of this project's C is right
    """

    said: list[str]
    folders: list[Path]
    good: bool


def keep(path: Path, out: Path, name: str = "") -> Kept:
    """Write a record of the board that a log is of into ``out``; of several boards, into folders in it.

    Raises LogError where nothing in the log can be used, RecordError where ``out`` can't be written.
    """
    log = read_board_log(path)
    found = boards(path, log)
    useful = [heard for heard in found if heard.asked]
    if not useful:
        raise LogError(f"{path}: {_nothing(log)}; run the board again, to the line `done`")
    said, good = _lost(log), True
    started = datetime.fromtimestamp(path.stat().st_mtime, UTC).isoformat(timespec="seconds")
    folders = [out]
    if len(useful) > 1:
        folders = [
            out / f"{i}-{slug(name or heard.board.processor)}" for i, heard in enumerate(useful, start=1)
        ]
    for heard, folder in zip(useful, folders, strict=True):
        good = _record(heard, name or heard.board.processor, started, folder, said) and good
    return Kept(said, folders, good)


def _record(heard: Heard, name: str, started: str, folder: Path, said: list[str]) -> bool:
    good, calls = True, 0
    with Writer(folder) as writer:
        first, *rest = lines(heard, name, started)
        assert isinstance(first, Header)
        writer.create(first)
        writer.extend(rest)
    for line in rest:
        if isinstance(line, Cell):
            calls += sum(times for _, times in line.singles)
            if line.judged is not None and line.judged.objection:
                said.append(f"{line.key.method} on {line.key.demands}: {line.judged.objection}")
                good = good and bool(heard.board.kernels[line.key.method].solver)
        elif isinstance(line, Emulated):
            calls += sum(times for _, times in line.instructions)
            if line.agrees is False:
                said.append(f"{line.method} on {line.demands}: not as in Python")
                good = good and line.solver != ""
    if heard.missing:
        more = f" and {len(heard.missing) - SHOWN} more" if len(heard.missing) > SHOWN else ""
        said.append(f"{name}: not whole, so left out: {', '.join(heard.missing[:SHOWN])}{more}")
    blocks = sum(len(runs) for (method, _), runs in heard.asked.items() if method != NOOP)
    said.append(f"{name}: {blocks} blocks, {calls} calls")
    return good


def _lost(log: BoardLog) -> list[str]:
    said = []
    if log.damaged or log.lost:
        said.append(_not_whole(log))
    if log.starts > 1:
        said.append(f"the log has {log.starts} starts, {log.finished} of which ran to the end")
    elif not log.finished:
        said.append("the log ends before the board had finished")
    return said + [f"the driver said: {words}" for words in log.nonsense]


def _nothing(log: BoardLog) -> str:
    if log.nonsense:
        return f"its driver said: {log.nonsense[0]}"
    return f"no method on any demand set arrived whole ({_not_whole(log)})"


def _not_whole(log: BoardLog) -> str:
    """How many lines are damaged, and how many are missing beside those: a damaged one has no number."""
    missing = max(log.lost - log.damaged, 0)
    return f"{plural(log.damaged, 'damaged line')}, {plural(missing, 'missing line')}"
