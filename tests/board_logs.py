"""A board's log as its driver prints it, made of lines that a test has changed."""

import re
import zlib


def opened(log: bytes) -> list[bytes]:
    """Each line of a log from behind its number, without its checksum."""
    return [line.split(b" ", 2)[2].rpartition(b" ")[0] for line in log.splitlines()]


def sealed(lines: list[bytes]) -> bytes:
    """The log of such lines: numbers and checksums are right."""
    printed, crc, header = list[bytes](), 0, b""
    for number, line in enumerate(lines):
        words = line.split(b" ")
        if words[0] in (b"board", b"demands", b"ask"):
            crc, words[1] = 0, header or words[1]
        body = b"tb %d %s" % (number, b" ".join(words))
        if words[0] == b"end":
            crc = zlib.crc32(b"tb %d end" % number, crc)
            body = b"tb %d end %08x" % (number, crc)
            header = header or b"%08x" % crc
        printed.append(b"%s %08x" % (body, zlib.crc32(body)))
        crc = zlib.crc32(printed[-1], crc)
    return b"\n".join(printed) + b"\n"


def forged(log: bytes, what: bytes, becomes: bytes) -> bytes:
    """A log in which a pattern was replaced in every line, with right check sums."""
    lines = opened(log)
    changed = [re.sub(what, becomes, line) for line in lines]
    assert changed != lines
    return sealed(changed)
