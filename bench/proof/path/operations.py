"""What VEX's operations give: of integers an integer, of numbers the operation that makes one."""

import re
import struct
from typing import Any

from bench.proof.path.cases import ByOutcome, Integer, combined
from bench.proof.path.numbers import Float, Numbers
from bench.proof.path.processor import CALLED, integers

Wide = dict[int, tuple[int, Any]]
"""A vector register's parts: offset to size and value."""
COMPARED = (0x01, 0x40, 0x00, 0x45)
"""VEX's codes for less, equal, greater and unordered."""
ARITHMETIC = re.compile(r"Iop_(Add|Sub|Mul|Div|Sqrt|Neg|Abs|MinNum|MaxNum)F(32|64)$")
LANES = re.compile(r"Iop_(Add|Sub|Mul|Div|Neg|Abs|Min|Max)(32Fx4|64Fx2)$")
ZEROED = {"Iop_ZeroHI64ofV128": 8, "Iop_ZeroHI96ofV128": 4}


class NotFollowed(Exception):
    """An instruction does what is not followed; the message says what."""


class Operations:
    """Operations on values, noting numbers."""

    def __init__(self, numbers: Numbers) -> None:
        """Note them there."""
        self._numbers = numbers

    def constant(self, constant: Any) -> Any:
        """A constant of the code."""
        if constant.type in ("Ity_F32", "Ity_F64"):
            if isinstance(constant.value, float):
                return self._numbers.number("const", constant.value)
            return self.typed(constant.value, constant.type)
        if constant.type == "Ity_V128":
            if constant.value:
                raise NotFollowed("a vector constant")
            return {0: (8, 0), 8: (8, 0)}
        return int(constant.value)

    def typed(self, value: Any, kind: str) -> Any:
        """A value read as a type: integers that were loaded as numbers become numbers."""
        if kind in ("Ity_F32", "Ity_F64") and isinstance(value, int):
            size = size_of(kind)
            (number,) = struct.unpack("<f" if size == 4 else "<d", value.to_bytes(size, "little"))
            return self._numbers.number("const", number)
        if kind in ("Ity_F32", "Ity_F64") and isinstance(value, ByOutcome):
            found_leaves = sorted(leaves(value))
            found = self.typed(found_leaves[0], kind)
            for leaf in found_leaves[1:]:
                at = combined(lambda x, y: int(x == y), value, leaf)
                found = self.chosen(at, self.typed(leaf, kind), found, size_of(kind))
            return found
        if kind.startswith("Ity_I") and isinstance(value, Float):
            operation = self._numbers.made[value.node]
            if operation[0] == "const":
                form = "<f" if kind == "Ity_I32" else "<d"
                return int.from_bytes(struct.pack(form, operation[1]), "little")
        return value

    def chosen(self, condition: Integer, a: Any, b: Any, size: int) -> Any:
        """One of two values, by a condition."""
        if not isinstance(condition, ByOutcome):
            return a if condition else b
        if a == b:
            return a
        if isinstance(a, Float) or isinstance(b, Float):
            kind = "Ity_F32" if size == 4 else "Ity_F64"
            a, b = self.typed(a, kind), self.typed(b, kind)
            return self._numbers.number("choose", condition, a.node, b.node)
        if isinstance(a, dict) or isinstance(b, dict):
            raise NotFollowed("a choice between vectors")
        return combined(lambda c, x, y: x if c else y, condition, a, b)

    def called(self, name: str, given: list[Any]) -> Integer:
        """What one of VEX's helpers gives; raises NotFollowed."""
        if name not in CALLED:
            raise NotFollowed(f"{name}")
        return combined(CALLED[name], *given)

    def operated(self, operation: str, operands: list[Any], kind: str) -> Any:
        """What an operation gives; raises NotFollowed."""
        if found := ARITHMETIC.match(operation):
            if int(found[2]) != 8 * self._numbers.scalar(0).itemsize:
                raise NotFollowed("another scalar")
            given = operands[1:] if found[1] in ("Add", "Sub", "Mul", "Div", "Sqrt") else operands
            name = found[1].lower().removesuffix("num")
            return self._numbers.number(name, *(each.node for each in given))
        if operation == "Iop_F32toF64":  # VEX compares floats as doubles; arithmetic on one is refused above
            return operands[0]
        if operation in ("Iop_CmpF64", "Iop_CmpF32"):
            return self._numbers.compare(operands[0], operands[1], COMPARED)
        if found := LANES.match(operation):
            lane = 4 if found[2] == "32Fx4" else 8
            vectors = [each for each in operands if isinstance(each, dict)]
            made: Wide = {}
            for at in range(0, 16, lane):
                parts = [self._lane(each, at, lane) for each in vectors]
                known = [each.node for each in parts if each is not None]
                if len(known) == len(parts):
                    made[at] = (lane, self._numbers.number(found[1].lower(), *known))
            return made
        if operation == "Iop_InterleaveLO64x2":
            high, low = ({at: part for at, part in each.items() if at < 8} for each in operands)
            return {**low, **{at + 8: part for at, part in high.items()}}
        if operation == "Iop_CatEvenLanes32x4":
            high, low = operands
            even = {0: low.get(0), 4: low.get(8), 8: high.get(0), 12: high.get(8)}
            return {at: part for at, part in even.items() if part and part[0] == 4}
        if operation in ZEROED:
            kept = {at: part for at, part in operands[0].items() if at < ZEROED[operation]}
            if sum(width for width, _ in kept.values()) != ZEROED[operation]:
                raise NotFollowed("a part of a vector")
            return {**kept, **dict.fromkeys(range(ZEROED[operation], 16, 4), (4, 0))}
        if operation.startswith("Iop_Reinterp"):
            return self.typed(operands[0], kind)
        if any(not isinstance(each, int | ByOutcome) for each in operands):
            raise NotFollowed(f"{operation} of numbers")
        function = integers(operation)
        if function is None:
            raise NotFollowed(operation)
        return combined(function, *operands)

    def _lane(self, vector: Wide, at: int, size: int) -> Float | None:
        """One number of a vector; None where it is not known."""
        width, part = vector.get(at, (0, 0))
        if isinstance(part, int) and width > size:
            width, part = size, part & ((1 << 8 * size) - 1)
        return self.typed(part, "Ity_F32" if size == 4 else "Ity_F64") if width == size else None


def leaves(integer: Integer) -> set[int]:
    """What an integer may be; raises NotFollowed of a number."""
    if isinstance(integer, ByOutcome):
        return set().union(*(leaves(leaf) for leaf in set(integer.leaves)))
    if not isinstance(integer, int):
        raise NotFollowed("a jump to a number")
    return {integer}


def size_of(kind: str) -> int:
    """Bytes of one of VEX's types."""
    return {"Ity_I1": 1, "Ity_V128": 16}.get(kind) or int(kind[5:]) // 8
