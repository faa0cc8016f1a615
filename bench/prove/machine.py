"""A binary followed on symbols: integers as they are, numbers by how they are calculated.

Whatever a kernel does with integers is known, or hangs on comparisons of numbers (``cases``). So its ways
are followed one by one, forking where a jump hangs on a comparison; of numbers only operations are noted.
"""

import re
import struct
from typing import Any, NamedTuple

from bench.prove.cases import Case, Integer, combined
from bench.prove.lifted import LEAVE, STACK, Lifted
from bench.prove.numbers import Float, Numbers
from bench.prove.places import Places
from bench.prove.processor import CALLED, holds, integers

Wide = dict[int, tuple[int, Any]]
"""A vector register's parts: offset to size and value."""
COMPARED = (0x01, 0x40, 0x00, 0x45)
"""VEX's codes for less, equal, greater and unordered."""
ARITHMETIC = re.compile(r"Iop_(Add|Sub|Mul|Div|Sqrt|Neg|Abs|MinNum|MaxNum)F(32|64)$")
LANES = re.compile(r"Iop_(Add|Sub|Mul|Div|Neg|Abs|Min|Max)(32Fx4|64Fx2)$")
ZEROED = {"Iop_ZeroHI64ofV128": 8, "Iop_ZeroHI96ofV128": 4}


class NotFollowed(Exception):
    """An instruction does what is not followed; the message says what."""


class Fork(NamedTuple):
    """One way to go on.

    Attributes
    ----------
    condition, holds : under which condition, and whether it holds; None where there is no other way
    state : where
    """

    condition: Integer
    holds: bool
    state: "State"


class State:
    """A processor between two jumps.

    Attributes
    ----------
    at : address of the block
    index, temporaries : of the statement in it that comes next, and what those before it gave
    executed : instructions so far
    frames : where to return to, the innermost last
    """

    __slots__ = ("at", "executed", "frames", "index", "memory", "registers", "temporaries")

    def __init__(self, at: int, registers: Places, memory: Places) -> None:
        """At a block's begin, with nothing executed."""
        self.at, self.registers, self.memory = at, registers, memory
        self.index, self.executed = 0, 0
        self.temporaries: dict[int, Any] = {}
        self.frames: tuple[int, ...] = ()

    def moved(self, to: int) -> "State":
        """This state at another block's begin."""
        state = State(to, self.registers.copy(), self.memory.copy())
        state.executed, state.frames = self.executed, self.frames
        return state


class Machine:
    """Follows one kernel's code."""

    def __init__(self, code: Lifted, numbers: Numbers) -> None:
        """Of an image, noting numbers."""
        self._code, self._numbers = code, numbers

    def start(self, entry: int, given: list[int]) -> State:
        """The call of a function with addresses and integers as arguments, and nothing in memory."""
        code = self._code
        registers = Places()
        state = State(entry, registers, Places())
        for i, value in enumerate(given[:4] if code.word == 4 else given):
            registers.write(code.register(str(i)), code.word, value)
        if code.word == 4:  # what doesn't fit four registers lies on the stack
            for i, value in enumerate(given[4:]):
                state.memory.write(STACK + 4 * i, 4, value)
        registers.write(code.register("sp"), code.word, STACK)
        registers.write(code.register("lr"), code.word, LEAVE | (code.word == 4))
        return state

    def step(self, state: State) -> list[Fork]:
        """Follow to the next fork, or to the end of the block; raises NotFollowed."""
        block = self._code.block(state.at)
        types = block.tyenv
        for index in range(state.index, len(block.statements)):
            statement = block.statements[index]
            match statement.tag:
                case "Ist_IMark":
                    state.executed += 1
                case "Ist_WrTmp":
                    state.temporaries[statement.tmp] = self._value(statement.data, state, types)
                case "Ist_Put":
                    self._put(
                        state.registers,
                        statement.offset,
                        self._value(statement.data, state, types),
                        _size(statement.data.result_type(types)),
                    )
                case "Ist_Store":
                    self._put(
                        state.memory,
                        self._integer(statement.addr, state, types),
                        self._value(statement.data, state, types),
                        _size(statement.data.result_type(types)),
                    )
                case "Ist_StoreG":
                    self._stored(statement, state, types)
                case "Ist_LoadG":
                    self._loaded(statement, state, types)
                case "Ist_Exit":
                    guard = self._value(statement.guard, state, types)
                    if isinstance(guard, Case):
                        taken = state.moved(self._code.address(statement.dst.value))
                        self._jumped(taken, statement.jumpkind)
                        state.index = index + 1
                        return [Fork(guard, True, taken), Fork(guard, False, state)]
                    if guard:
                        return [
                            Fork(
                                1,
                                True,
                                self._jumped(
                                    state.moved(self._code.address(statement.dst.value)), statement.jumpkind
                                ),
                            )
                        ]
                case "Ist_AbiHint" | "Ist_NoOp" | "Ist_MBE":
                    pass
                case other:
                    raise NotFollowed(f"{other} at {state.at:#x}")
        to = self._value(block.next, state, types)
        if block.jumpkind == "Ijk_Call":
            state.frames = (*state.frames, state.at + block.size)
        elif state.frames and to == state.frames[-1] + (self._code.word == 4):
            state.frames = state.frames[:-1]
        targets = sorted(_leaves(to))
        if len(targets) == 1:
            return [Fork(1, True, self._jumped(state.moved(self._code.address(targets[0])), block.jumpkind))]
        return [
            Fork(
                combined(lambda x, y: int(x == y), to, target),
                True,
                self._jumped(state.moved(self._code.address(target)), block.jumpkind),
            )
            for target in targets
        ]

    def _jumped(self, state: State, kind: str) -> State:
        if kind not in ("Ijk_Boring", "Ijk_Call", "Ijk_Ret"):
            raise NotFollowed(f"{kind} at {state.at:#x}")
        return state

    def _stored(self, statement: Any, state: State, types: Any) -> None:
        at, size = self._integer(statement.addr, state, types), _size(statement.data.result_type(types))
        value, guard = (self._value(each, state, types) for each in (statement.data, statement.guard))
        if isinstance(guard, Case):
            value = self._chosen(guard, value, self._read(state.memory, at, size), size)
        if guard:
            self._put(state.memory, at, value, size)

    def _loaded(self, statement: Any, state: State, types: Any) -> None:
        at, size = self._integer(statement.addr, state, types), _size(types.lookup(statement.dst))
        guard, other = (self._value(each, state, types) for each in (statement.guard, statement.alt))
        if guard and statement.cvt_types[0] != statement.cvt_types[1]:
            raise NotFollowed(f"a conditional load that converts, at {state.at:#x}")
        value = self._read(state.memory, at, size) if guard else other
        if isinstance(guard, Case):
            value = self._chosen(guard, value, other, size)
        state.temporaries[statement.dst] = value

    def _integer(self, expression: Any, state: State, types: Any) -> int:
        value = self._value(expression, state, types)
        if not isinstance(value, int):
            raise NotFollowed(f"an address that hangs on numbers, at {state.at:#x}")
        return value

    def _value(self, expression: Any, state: State, types: Any) -> Any:
        match expression.tag:
            case "Iex_RdTmp":
                return state.temporaries[expression.tmp]
            case "Iex_Const":
                return self._constant(expression.con)
            case "Iex_Get":
                size = _size(expression.ty)
                found = state.registers.read(expression.offset, size)
                if found is None:  # what a caller left there, or a mode of the processor's: as after a reset
                    if state.registers.touches(expression.offset, size) and size < 16:
                        raise NotFollowed(f"a part of a register, at {state.at:#x}")
                    found = {} if size == 16 else 0
                return self._typed(found, expression.ty)
            case "Iex_Load":
                at = self._integer(expression.addr, state, types)
                return self._typed(self._read(state.memory, at, _size(expression.ty)), expression.ty)
            case "Iex_ITE":
                condition, a, b = (
                    self._value(each, state, types)
                    for each in (expression.cond, expression.iftrue, expression.iffalse)
                )
                return self._chosen(condition, a, b, _size(expression.result_type(types)))
            case "Iex_CCall":
                return self._called(
                    expression.cee.name, [self._value(each, state, types) for each in expression.args]
                )
        operands = [self._value(each, state, types) for each in expression.args]
        return self._operated(expression.op, operands, expression.result_type(types))

    def _constant(self, constant: Any) -> Any:
        if constant.type in ("Ity_F32", "Ity_F64"):
            if isinstance(constant.value, float):
                return self._numbers.number("const", constant.value)
            return self._typed(constant.value, constant.type)
        if constant.type == "Ity_V128":
            if constant.value:
                raise NotFollowed("a vector constant")
            return {0: (8, 0), 8: (8, 0)}
        return int(constant.value)

    def _typed(self, value: Any, kind: str) -> Any:
        """A value read as a type: integers that were loaded as numbers become numbers."""
        if kind in ("Ity_F32", "Ity_F64") and isinstance(value, int):
            size = _size(kind)
            (number,) = struct.unpack("<f" if size == 4 else "<d", value.to_bytes(size, "little"))
            return self._numbers.number("const", number)
        if kind in ("Ity_F32", "Ity_F64") and isinstance(value, Case):
            leaves = sorted(_leaves(value))
            found = self._typed(leaves[0], kind)
            for leaf in leaves[1:]:
                at = combined(lambda x, y: int(x == y), value, leaf)
                found = self._chosen(at, self._typed(leaf, kind), found, _size(kind))
            return found
        if kind.startswith("Ity_I") and isinstance(value, Float):
            operation = self._numbers.made[value.node]
            if operation[0] == "const":
                form = "<f" if kind == "Ity_I32" else "<d"
                return int.from_bytes(struct.pack(form, operation[1]), "little")
        return value

    def _read(self, memory: Places, at: int, size: int) -> Any:
        found = memory.read(at, size)
        if found is None:
            content = self._code.constants(at, size)
            if len(content) != size or memory.touches(at, size):
                raise NotFollowed(f"a read of what nothing has written, at {at:#x}")
            if size == 16:
                return {i: (8, int.from_bytes(content[i : i + 8], "little")) for i in (0, 8)}
            return int.from_bytes(content, "little")
        return found

    def _put(self, places: Places, at: int, value: Any, size: int) -> None:
        if not isinstance(value, dict):
            places.write(at, size, value)
            return
        places.clear(at, size)
        for offset, (width, part) in value.items():
            places.write(at + offset, width, part)

    def _chosen(self, condition: Integer, a: Any, b: Any, size: int) -> Any:
        if not isinstance(condition, Case):
            return a if condition else b
        if a == b:
            return a
        if isinstance(a, Float) or isinstance(b, Float):
            kind = "Ity_F32" if size == 4 else "Ity_F64"
            a, b = self._typed(a, kind), self._typed(b, kind)
            return self._numbers.number("choose", condition, a.node, b.node)
        if isinstance(a, dict) or isinstance(b, dict):
            raise NotFollowed("a choice between vectors")
        return combined(lambda c, x, y: x if c else y, condition, a, b)

    def _called(self, name: str, given: list[Any]) -> Integer:
        if name not in CALLED:
            raise NotFollowed(f"{name}")
        return combined(CALLED[name], *given)

    def _operated(self, operation: str, operands: list[Any], kind: str) -> Any:
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
            return self._typed(operands[0], kind)
        if any(not isinstance(each, int | Case) for each in operands):
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
        return self._typed(part, "Ity_F32" if size == 4 else "Ity_F64") if width == size else None


def returned(machine: Machine, state: State) -> Integer:
    """What a function that has returned returned: a status."""
    found = state.registers.read(machine._code.register("0"), 4)
    return combined(lambda x: x - (1 << 32) if x >> 31 else x, 0 if found is None else found)


def _leaves(integer: Integer) -> set[int]:
    if isinstance(integer, Case):
        return set().union(*(_leaves(leaf) for leaf in set(integer.leaves)))
    if not isinstance(integer, int):
        raise NotFollowed("a jump to a number")
    return {integer}


def _size(kind: str) -> int:
    return {"Ity_I1": 1, "Ity_V128": 16}.get(kind) or int(kind[5:]) // 8


__all__ = ["Fork", "Machine", "NotFollowed", "State", "holds", "returned"]
