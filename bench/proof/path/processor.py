"""What VEX's operations do with integers, and what a processor's flags say."""

import re
from collections.abc import Callable
from functools import cache

SIMPLE = re.compile(r"Iop_(Add|Sub|Mul|And|Or|Xor|Shl|Shr|Sar|CmpEQ|CmpNE)(\d+)$")
ORDERED = re.compile(r"Iop_Cmp(LT|LE)(\d+)([SU])$")
WIDENED = re.compile(r"Iop_(\d+)([SU])to(\d+)$")
CUT = re.compile(r"Iop_(\d+)to(\d+)$")


@cache
def integers(operation: str) -> Callable[..., int] | None:
    """The function on integers that a VEX operation is; None where it is not known."""
    if found := SIMPLE.match(operation):
        return _simple(found[1], int(found[2]))
    if found := ORDERED.match(operation):
        size, signed = int(found[2]), found[3] == "S"
        less = found[1] == "LT"

        def ordered(a: int, b: int) -> int:
            x, y = (_signed(a, size), _signed(b, size)) if signed else (a, b)
            return int(x < y if less else x <= y)

        return ordered
    if found := WIDENED.match(operation):
        narrow, wide, signed = int(found[1]), int(found[3]), found[2] == "S"
        return lambda a: _cut(_signed(a, narrow), wide) if signed else a
    if found := CUT.match(operation):
        size = int(found[2])
        return lambda a: _cut(a, size)
    if found := re.match(r"Iop_Not(\d+)$", operation):
        size = int(found[1])
        return lambda a: _cut(~a, size)
    if operation == "Iop_64HIto32":
        return lambda a: a >> 32
    if operation == "Iop_32HLto64":
        return lambda high, low: high << 32 | low
    return None


def _simple(name: str, size: int) -> Callable[..., int]:
    functions: dict[str, Callable[[int, int], int]] = {
        "Add": lambda a, b: a + b,
        "Sub": lambda a, b: a - b,
        "Mul": lambda a, b: a * b,
        "And": lambda a, b: a & b,
        "Or": lambda a, b: a | b,
        "Xor": lambda a, b: a ^ b,
        "Shl": lambda a, b: a << b,
        "Shr": lambda a, b: a >> b,
        "Sar": lambda a, b: _signed(a, size) >> b,
        "CmpEQ": lambda a, b: int(a == b),
        "CmpNE": lambda a, b: int(a != b),
    }
    function = functions[name]
    return lambda a, b: _cut(function(a, b), size)


def _cut(a: int, size: int) -> int:
    return a & ((1 << size) - 1)


def _signed(a: int, size: int) -> int:
    return a - (1 << size) if a >> (size - 1) else a


def holds(condition: int, n: int, z: int, c: int, v: int) -> int:
    """Whether one of the sixteen conditions that both Arm processors know holds for these flags."""
    kinds = (z, c, n, v, c and not z, n == v, n == v and not z, True)
    found = bool(kinds[condition >> 1])
    return int(found != bool(condition & 1) or condition >= 14)


def _flags(operation: int, a: int, b: int, extra: int, wide: bool) -> tuple[int, int, int, int]:
    """Negative, zero, carry, overflow after an operation as VEX numbers it, of 32 bits or (``wide``) both."""
    if operation == 0:  # the flags themselves
        return a >> 31 & 1, a >> 30 & 1, a >> 29 & 1, a >> 28 & 1
    kind = ("add", "add", "sub", "sub", "adc", "adc", "sbc", "sbc", "logic", "logic")
    names = kind if wide else ("add", "sub", "adc", "sbc", "logic")
    name = names[operation - 1]
    size = 64 if wide and operation % 2 == 0 else 32
    a, b = _cut(a, size), _cut(b, size)
    if name == "logic":
        carry, over = (0, 0) if wide else (b & 1, extra & 1)
        return a >> (size - 1), int(a == 0), carry, over
    if name in ("sub", "sbc"):
        b = _cut(~b, size)
    carried = {"add": 0, "sub": 1}.get(name, extra & 1)
    total = a + b + carried
    result = _cut(total, size)
    over = (~(a ^ b) & (a ^ result)) >> (size - 1) & 1
    return result >> (size - 1), int(result == 0), total >> size & 1, over


def _condition(wide: bool) -> Callable[..., int]:
    return lambda asked, a, b, extra: holds(asked >> 4 & 15, *_flags(asked & 15, a, b, extra, wide))


def _flag(which: int, wide: bool) -> Callable[..., int]:
    return lambda operation, a, b, extra: _flags(operation, a, b, extra, wide)[which]


def _packed(wide: bool) -> Callable[..., int]:
    def packed(operation: int, a: int, b: int, extra: int) -> int:
        n, z, c, v = _flags(operation, a, b, extra, wide)
        return n << 31 | z << 30 | c << 29 | v << 28

    return packed


CALLED: dict[str, Callable[..., int]] = {
    f"{arm}_calculate_{what}": function
    for arm, wide in (("armg", False), ("arm64g", True))
    for what, function in (
        ("condition", _condition(wide)),
        ("flag_c", _flag(2, wide)),
        ("flag_v", _flag(3, wide)),
        ("flags_nzcv", _packed(wide)),
    )
}
"""VEX's helpers, by name."""
