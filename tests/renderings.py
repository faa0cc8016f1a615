"""Contents of two rendered files: structure and words have to be the same, numbers nearly.

Pictures and tables hold what numpy and the C library compute, whose last digits belong to the processor.
"""

import re
from decimal import Decimal
from xml.etree import ElementTree

_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", re.IGNORECASE)
_NAME = re.compile(r"(?<=url\(#)[\w-]+")
PIXEL = Decimal("0.01")
"""Most that a coordinate of a picture may move [px]: nobody sees it, and rounding moves one by 1e-6."""


def differences(made: str, kept: str, svg: bool = False) -> list[str]:
    """Differences between two renderings, in words; empty where they show the same.

    Whole numbers are counts and have to be equal. Others may differ by one unit of the last digit that is
    printed, as a value does that lies between two of them; in a picture by PIXEL.
    """
    ours, theirs = (_drawn(text) if svg else text.splitlines() for text in (made, kept))
    found = [f"{len(ours)} lines or elements, not {len(theirs)}"] if len(ours) != len(theirs) else []
    for number, (line, other) in enumerate(zip(ours, theirs, strict=False), start=1):
        if line != other and not _alike(line, other, PIXEL if svg else None):
            found.append(f"{number}: {line[:200]!r} is not {other[:200]!r}")
    return found


def _alike(line: str, other: str, most: Decimal | None) -> bool:
    if _NUMBER.sub("0", line) != _NUMBER.sub("0", other):
        return False
    pairs = zip(_NUMBER.findall(line), _NUMBER.findall(other), strict=True)
    return all(abs(Decimal(a) - Decimal(b)) <= (most or max(_unit(a), _unit(b))) for a, b in pairs)


def _unit(number: str) -> Decimal:
    """One in the last digit that is printed; nothing for a whole number."""
    digits, _, power = number.lower().partition("e")
    decimals = len(digits.partition(".")[2])
    return Decimal(1).scaleb(int(power or 0) - decimals) if decimals or power else Decimal(0)


def _drawn(svg: str) -> list[str]:
    """A line an element: its tag, attributes and text; names, hashes of numbers, become their order."""
    order: dict[str, int] = {}
    lines = []
    for element in ElementTree.fromstring(svg).iter():
        words = [element.tag]
        for key, value in sorted(element.attrib.items()):
            named = [value.lstrip("#")] if key.endswith(("id", "href")) else _NAME.findall(value)
            for name in named:
                value = value.replace(name, f"name{order.setdefault(name, len(order))}")
            words.append(f"{key}={value}")
        lines.append(" ".join([*words, (element.text or "").strip()]))
    return lines
