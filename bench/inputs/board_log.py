"""Reads what the driver of ``thrustbench board`` printed: the blocks that arrived whole, and what did not.

A line is ``tb <number> <kind> … <CRC-32>``, the CRC over what stands before it. A block is kept where every
line from its first to its ``end`` is there, numbered without a gap, each with the right CRC, and the text of
all of them has the CRC that the ``end`` holds. Its first line names the header that it belongs to, by the CRC
of the header's block. The driver is bench/chips/firmware/driver.c.
"""

import re
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from alloc import AllocError
from alloc.allocation import FloatArray, IndexArray

LARGEST = 1 << 30
"""Bytes of a log that are read at most."""
_CRC = 9
"""Bytes of a line's checksum, with the blank before it."""
_EDGE = re.compile(rb"tb (\d{1,10}) (board|demands|ask|end) (?=([^\n]*))")
"""The first line of a block, or its last."""

_ENDS = re.compile(rb"(?:[ \t\f]|\x1b\[[\d;]*[mK])+$", re.MULTILINE)
"""Blanks and colours that a terminal puts behind each line."""


class LogError(AllocError):
    """A board's log can't be used; the message says why and what to do."""


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
    lines: list[bytes]

    def texts(self, kind: str) -> list[bytes]:
        """Texts of the lines of a kind, in order, without number, kind and CRC."""
        return self._by_kind.get(kind.encode(), [])

    @cached_property
    def _by_kind(self) -> dict[bytes, list[bytes]]:
        found = defaultdict[bytes, list[bytes]](list)
        for line in self.lines:
            _, _, kind, rest = line.split(b" ", 3)
            found[kind].append(rest[:-_CRC])
        return found

    def rows(self, kind: str) -> list[list[str]]:
        """The words of the lines of a kind, in order."""
        return [_words(text) for text in self.texts(kind)]


@dataclass
class BoardLog:
    """Content of a board's log.

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
    # Most serial terminals end a line with both, and PowerShell saves what it is sent as UTF-16.
    text = text.replace(b"\0", b"").replace(b"\r", b"\n")
    log = _parsed(text)
    # Not at once: where a terminal wraps lines, a blank at a line's end is the driver's.
    return log if log.blocks else _parsed(_ENDS.sub(b"", text))


def _parsed(text: bytes) -> BoardLog:
    log = BoardLog()
    begin: re.Match[bytes] | None = None
    seen_to = expected = 0
    for edge in _EDGE.finditer(text):
        if edge[2] != b"end":
            begin = edge
        elif begin is not None and (block := _block(log, begin, edge)):
            expected = _outside(log, text[seen_to : begin.start()], expected)
            expected = _numbered(log, int(begin[1]), block.kind == "board", expected)
            log.blocks.append(block)
            seen_to, expected, begin = edge.end(3), int(edge[1]) + 1, None
    _outside(log, text[seen_to:], expected)
    return log


def _block(log: BoardLog, begin: re.Match[bytes], end: re.Match[bytes]) -> LogBlock | None:
    """Content between two edges, if its text has the CRC that its last line holds."""
    head, claimed = b"tb %s end" % end[1], end[3][:-_CRC]
    if end[3][-_CRC:] != b" %08x" % zlib.crc32(b"%s %s" % (head, claimed)):
        return None
    body = begin.string[begin.start() : end.start()]
    # Some terminals wrap lines; no line of a driver has a break in it, and zeros were taken out.
    lines = body.replace(b"\ntb ", b"\0tb ").replace(b"\n", b"").split(b"\0")
    if claimed != b"%08x" % zlib.crc32(head, zlib.crc32(b"".join(lines))):
        lines = list(_lines(body))  # perhaps something else was printed in between
        if claimed != b"%08x" % zlib.crc32(head, zlib.crc32(b"".join(lines))):
            return None
        log.damaged += body.count(b"tb ") - len(lines)
    kind, words = begin[2].decode(), _words(lines[0].split(b" ", 3)[-1][:-_CRC])
    if not words:
        return None
    return LogBlock(kind, claimed.decode() if kind == "board" else words[0], words[1:], lines[1:])


def _outside(log: BoardLog, text: bytes, expected: int) -> int:
    """Count what is no part of a whole block; returns the number that the next line should have."""
    log.damaged += text.count(b"tb ")
    for line in _lines(text):
        log.damaged -= 1
        _, number, kind, rest = line.split(b" ", 3)
        words = _words(rest[:-_CRC])
        expected = _numbered(log, int(number), kind == b"board", expected)
        if kind in (b"board", b"demands", b"ask"):
            log.broken.append(" ".join(words[1:]) or "header")
        elif kind == b"nonsense":
            log.nonsense.append(" ".join(words))
        elif kind == b"done":
            log.finished += 1
    return expected


def _numbered(log: BoardLog, number: int, starts: bool, expected: int) -> int:
    """Count the lines that are missing before this one, or a start; returns the next line's number."""
    if starts or number < expected:
        log.starts += 1
        expected = 0 if starts else number
    log.lost += number - expected
    return number + 1


def _words(text: bytes) -> list[str]:
    """Words of a line; U+FFFD for what would move a terminal's cursor, or is no text at all."""
    return text.decode("ascii", "replace").translate(_CONTROLS).split()


_CONTROLS = dict.fromkeys([*range(32), 127], "\ufffd")
COUNTER = (1 << 32) - 1
"""The largest number that a driver prints: it counts in 32 bits."""


def whole(word: str, most: int = COUNTER) -> int:
    """The number that a word says, 0 to ``most``; raises ValueError for anything else."""
    if not (word.isdecimal() and len(word) <= len(str(most)) and int(word) <= most):
        raise ValueError(f"{word[:40]!r} where a number from 0 to {most} stands")
    return int(word)


def _lines(text: bytes) -> Iterator[bytes]:
    """Each whole line: its CRC-32 is right, and it has a number and a kind."""
    for line in text.split(b"\n"):
        line = line[max(0, line.rfind(b"tb ")) :]  # what stands before may be half a line of another start
        parts = line.split(b" ", 3)
        numbered = len(parts) == 4 and parts[0] == b"tb" and parts[1].isdigit() and len(parts[1]) <= 10
        if numbered and line[-_CRC:] == b" %08x" % zlib.crc32(line[:-_CRC]):
            yield line


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


def tick_counts(block: LogBlock, kind: str) -> list[tuple[int, int]]:
    """Ticks and how often they were seen, of a block's lines of that kind, sorted."""
    times: Counter[int] = Counter()
    numbers = [whole(word.decode("ascii", "replace")) for word in b" ".join(block.texts(kind)).split()]
    for ticks, often in zip(numbers[::2], numbers[1::2], strict=True):
        times[ticks] += often
    return sorted(times.items())
