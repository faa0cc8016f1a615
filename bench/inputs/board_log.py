"""Reads what the driver of ``thrustbench board`` printed: the blocks that arrived whole, and what did not.

A line is ``tb <number> <kind> … <CRC-32>``, the CRC over what stands before it. A block is kept where every
line from its first to its ``end`` is there, numbered without a gap, each with the right CRC, and the text of
all of them has the CRC that the ``end`` holds. Its first line names the header that it belongs to, by the CRC
of the header's block. The driver is bench/emulation/firmware/driver.c.
"""

import re
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from alloc import AllocError, FloatArray, IndexArray

LARGEST = 1 << 30
"""Bytes of a log that are read at most."""
_LINE = re.compile(rb"(tb (\d{1,10}) ([a-z_]+)((?: [ -~]*?)?)) ([0-9a-f]{8})(?=[\r\n]|$)")
_BEGINS = ("board", "demands", "ask")


class LogError(AllocError):
    """A board's log can't be used; the message says why and what to do."""


class Line(NamedTuple):
    """One line: its number since the start of the board, its kind, and its words."""

    number: int
    kind: str
    words: list[str]


@dataclass(frozen=True)
class LogBlock:
    """Lines that belong together, whole.

    Attributes
    ----------
    kind : board, demands or ask
    header : CRC of the header that it belongs to; a header's own
    words : of its first line, without the header's CRC
    lines : those between the first and the last
    """

    kind: str
    header: str
    words: list[str]
    lines: list[Line]


@dataclass
class BoardLog:
    """What arrived.

    Attributes
    ----------
    blocks : whole ones, in the order of the file
    starts : how often a board began to print
    finished : how often one printed to its end
    damaged : lines whose CRC is wrong, or that were cut
    lost : lines that are missing between others
    broken : the first lines' words of blocks that are not whole, with how many lines they lack
    nonsense : what a driver said of its port's ticks
    """

    blocks: list[LogBlock] = field(default_factory=list)
    starts: int = 0
    finished: int = 0
    damaged: int = 0
    lost: int = 0
    broken: list[str] = field(default_factory=list)
    nonsense: list[str] = field(default_factory=list)


def read_board_log(path: Path) -> BoardLog:
    """The log in a file; raises LogError where it can't be read or holds no line of a driver."""
    try:
        if path.stat().st_size > LARGEST:
            raise LogError(f"{path}: is larger than {LARGEST >> 30} GiB; give what one board printed")
        text = path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: can't be read ({error.strerror}); give what a board printed") from None
    log = parse(text)
    if not log.blocks and not log.broken and not log.damaged:
        raise LogError(
            f"{path}: holds no line of the driver that `thrustbench board` writes; give its output"
        )
    return log


def parse(text: bytes) -> BoardLog:
    """The blocks in a text, whatever stands between them."""
    log = BoardLog()
    opened: Line | None = None
    inside: list[Line] = []
    crc, expected = 0, 0
    for line, line_text in _lines(text, log):
        if line.number < expected or line.kind == "board":
            log.starts += 1
            expected = 0 if line.kind == "board" else line.number
        log.lost += line.number - expected
        whole = line.number == expected
        expected = line.number + 1
        if opened is not None and (not whole or line.kind in _BEGINS):
            log.broken.append(" ".join(opened.words[1:]) or "header")
            opened = None
        if line.kind in _BEGINS:
            opened, inside, crc = line, [], zlib.crc32(line_text)
        elif line.kind == "nonsense":
            log.nonsense.append(" ".join(line.words))
            opened = None
        elif line.kind == "done":
            log.finished += 1
        elif opened is not None and line.kind == "end":
            crc = zlib.crc32(b"tb %d end" % line.number, crc)
            if line.words == [f"{crc:08x}"] and opened.words:
                header = line.words[0] if opened.kind == "board" else opened.words[0]
                log.blocks.append(LogBlock(opened.kind, header, opened.words[1:], inside))
            else:
                log.broken.append(" ".join(opened.words[1:]) or "header")
            opened = None
        elif opened is not None:
            inside.append(line)
            crc = zlib.crc32(line_text, crc)
    if opened is not None:
        log.broken.append(" ".join(opened.words[1:]) or "header")
    return log


def _lines(text: bytes, log: BoardLog) -> Iterator[tuple[Line, bytes]]:
    """Each whole line, with its text as the block's CRC has it."""
    begun = text.count(b"tb ")
    whole = 0
    for match in _LINE.finditer(text):
        body, number, kind, words, crc = match.groups()
        if zlib.crc32(body) == int(crc, 16):
            whole += 1
            yield Line(int(number), kind.decode(), words.decode().split()), body + b" " + crc
    log.damaged = max(0, begun - whole)


class Answered(NamedTuple):
    """The answers of a block of kind ask, N of them.

    Attributes
    ----------
    F : (N, n) thrusts as the kernel left them [N]
    status : (N,) what it returned
    ticks : (N,) of the first pass
    stack_bytes : (N,) that the kernel wrote to, 0 where the driver was not built to look at it
    """

    F: FloatArray
    status: IndexArray
    ticks: IndexArray
    stack_bytes: IndexArray


def answered(block: LogBlock, n: int, scalar: np.dtype[Any]) -> Answered:
    """The answers of a block of kind ask, of n thrusters; raises LogError where its lines hold others."""
    rows = [line.words for line in block.lines if line.kind == "f"]
    try:
        counted = np.array([[int(row[i]) for i in range(3)] for row in rows]).reshape(-1, 3)
        stack = np.array([int(row[3 + n]) if len(row) > 3 + n else 0 for row in rows])
        bits = bytes.fromhex("".join("".join(row[3 : 3 + n]) for row in rows))
        F = np.frombuffer(bits, scalar.newbyteorder(">")).reshape(len(rows), n).astype(np.float64)
    except (ValueError, IndexError, OverflowError):
        counted, F = np.full((1, 3), -1), np.empty((0, n))
    if not np.array_equal(counted[:, 0], np.arange(len(F))):
        raise LogError(f"{' '.join(block.words)}: lines of another driver; take the project's own")
    status = counted[:, 1].astype(np.uint32).astype(np.int32)  # two's complement
    return Answered(F, status.astype(np.intp), counted[:, 2], stack)


def seen(block: LogBlock, kind: str) -> list[tuple[int, int]]:
    """Ticks and how often they were seen, of a block's lines of that kind, sorted."""
    times: Counter[int] = Counter()
    for line in block.lines:
        if line.kind == kind:
            numbers = [int(word) for word in line.words]
            for ticks, often in zip(numbers[::2], numbers[1::2], strict=True):
                times[ticks] += often
    return sorted(times.items())
