"""Damage for fuzz tests: bytes and JSON changed in ways that files are damaged, or made by hand, in fact."""

import json
import re
import struct
from collections.abc import Callable
from typing import Any

import numpy as np

NUMBERS = (
    *("nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e400", "0", "-0.0", "-1", "1", "2", "0.5", "1e16"),
    *("9223372036854775808", "-99999999999999999999999", "1_000", "0x1f", "1.5.2", "true", "null", "''"),
)
"""Values put in a number's place: beyond each type's range, on its edge, or no number at all."""
PIECES = (
    *(
        b"\0",
        b"\xff\xfe",
        b"\r",
        b"\n",
        b"\t",
        b",",
        b";",
        b":",
        b"#",
        b"- ",
        b"[",
        b"]",
        b"{",
        b"}",
        b'"',
        b"'",
    ),
    *(b"&a ", b"*a", b"!!str ", b"<<: ", b"%", b"\\", b"\xe2\x80\xa8", "\u202e".encode(), b"  ", b"\x1b[2J"),
)
"""Bytes put between others: separators, brackets, YAML's and JSON's signs, line ends that are none."""
WORDS = (
    struct.pack("<d", np.nan),
    struct.pack("<d", 1e308),
    struct.pack("<f", np.inf),
    b"\xff" * 8,
    bytes(8),
)
"""Bytes put over others in binary files: numbers beyond any range, lengths beyond the file."""
VALUES: tuple[Any, ...] = (
    *(None, True, -1, 0, 1, 2**63, 1e308, -1e308, 0.5, "", "x", "1e5", [], [[]], {}, [None]),
)
"""Values put in the place of a value of a JSON document."""

_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_]\w*")


def damaged(data: bytes, rng: np.random.Generator, binary: bool = False) -> bytes:
    """The bytes after one to three changes; ``binary`` files are changed as bytes, others as text."""
    kinds = BINARY if binary else TEXT
    for _ in range(rng.integers(1, 4)):
        data = kinds[rng.integers(len(kinds))](data, rng)
    return data


def damaged_json(document: Any, rng: np.random.Generator) -> Any:
    """A copy of a JSON document in which one value was changed, removed or repeated."""
    document = json.loads(json.dumps(document))
    places = list(_places(document))
    if not places:
        return document
    holder, key = places[rng.integers(len(places))]
    what = rng.integers(6)
    if what == 0:
        del holder[key]
    elif what == 1 and isinstance(holder, list):
        holder.extend(holder[key:])
    elif what < 4:  # another value of the same kind gets past more checks than one of another kind
        same = [value for value in VALUES if type(value) is type(holder[key])] or list(VALUES)
        holder[key] = same[rng.integers(len(same))]
    else:
        holder[key] = VALUES[rng.integers(len(VALUES))]
    return document


def _places(document: Any) -> Any:
    """(container, key) of each value in a document."""
    keys = (
        document if isinstance(document, dict) else range(len(document)) if isinstance(document, list) else ()
    )
    for key in keys:
        yield document, key
        yield from _places(document[key])


def _at(data: bytes, rng: np.random.Generator) -> int:
    return int(rng.integers(len(data) + 1))


def _span(data: bytes, rng: np.random.Generator) -> bytes:
    """A short span left out, or twice."""
    start = _at(data, rng)
    end = start + int(rng.integers(1, 20))
    return data[:start] + data[start:end] * int(rng.choice([0, 2])) + data[end:]


def _piece(data: bytes, rng: np.random.Generator) -> bytes:
    at = _at(data, rng)
    return data[:at] + PIECES[rng.integers(len(PIECES))] + data[at:]


def _overwritten(data: bytes, rng: np.random.Generator) -> bytes:
    at = _at(data, rng)
    word = WORDS[rng.integers(len(WORDS))] if rng.integers(2) else bytes([rng.integers(256)])
    return data[:at] + word + data[at + len(word) :]


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: _at(data, rng)] if rng.integers(3) == 0 else data


def _number(data: bytes, rng: np.random.Generator) -> bytes:
    return _replaced(_NUMBER, data, rng, lambda _: NUMBERS[rng.integers(len(NUMBERS))].encode())


def _word(data: bytes, rng: np.random.Generator) -> bytes:
    words = _WORD.findall(data) or [b"x"]
    return _replaced(_WORD, data, rng, lambda _: words[rng.integers(len(words))])


def _line(data: bytes, rng: np.random.Generator) -> bytes:
    """A line moved to another line's place, left out, or twice."""
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    moved = lines[rng.integers(len(lines))]
    if rng.integers(2):
        lines.remove(moved)
    if rng.integers(2):
        lines.insert(int(rng.integers(len(lines) + 1)), moved)
    return b"".join(lines)


def _replaced(
    pattern: re.Pattern[bytes], data: bytes, rng: np.random.Generator, by: Callable[[bytes], bytes]
) -> bytes:
    found = list(pattern.finditer(data))
    if not found:
        return data
    match = found[rng.integers(len(found))]
    return data[: match.start()] + by(match[0]) + data[match.end() :]


TEXT = (_span, _piece, _number, _number, _line, _word, _cut)
BINARY = (_span, _overwritten, _overwritten, _cut)
