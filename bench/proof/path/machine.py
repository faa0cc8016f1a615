"""A binary followed on symbols: integers as they are, numbers by how they are calculated.

Whatever a kernel does with integers is known, or hangs on comparisons of numbers (``cases``). So its ways
are followed one by one, forking where a jump hangs on a comparison; of numbers only operations are noted.
"""

from typing import Any, NamedTuple

from bench.proof.path.cases import ByOutcome, Integer, combined
from bench.proof.path.lifted import LEAVE, STACK, Lifted
from bench.proof.path.numbers import Numbers
from bench.proof.path.operations import NotFollowed, Operations, leaves, size_of
from bench.proof.path.places import Places


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


class Follower:
    """Follows one kernel's code."""

    def __init__(self, code: Lifted, numbers: Numbers) -> None:
        """Of an image, noting numbers."""
        self._code, self._operations = code, Operations(numbers)

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
                        size_of(statement.data.result_type(types)),
                    )
                case "Ist_Store":
                    self._put(
                        state.memory,
                        self._integer(statement.addr, state, types),
                        self._value(statement.data, state, types),
                        size_of(statement.data.result_type(types)),
                    )
                case "Ist_StoreG":
                    self._stored(statement, state, types)
                case "Ist_LoadG":
                    self._loaded(statement, state, types)
                case "Ist_Exit":
                    guard = self._value(statement.guard, state, types)
                    if isinstance(guard, ByOutcome):
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
        targets = sorted(leaves(to))
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
        at, size = self._integer(statement.addr, state, types), size_of(statement.data.result_type(types))
        value, guard = (self._value(each, state, types) for each in (statement.data, statement.guard))
        if isinstance(guard, ByOutcome):
            value = self._operations.chosen(guard, value, self._read(state.memory, at, size), size)
        if guard:
            self._put(state.memory, at, value, size)

    def _loaded(self, statement: Any, state: State, types: Any) -> None:
        at, size = self._integer(statement.addr, state, types), size_of(types.lookup(statement.dst))
        guard, other = (self._value(each, state, types) for each in (statement.guard, statement.alt))
        if guard and statement.cvt_types[0] != statement.cvt_types[1]:
            raise NotFollowed(f"a conditional load that converts, at {state.at:#x}")
        value = self._read(state.memory, at, size) if guard else other
        if isinstance(guard, ByOutcome):
            value = self._operations.chosen(guard, value, other, size)
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
                return self._operations.constant(expression.con)
            case "Iex_Get":
                size = size_of(expression.ty)
                found = state.registers.read(expression.offset, size)
                if found is None:  # what a caller left there, or a mode of the processor's: as after a reset
                    if state.registers.touches(expression.offset, size) and size < 16:
                        raise NotFollowed(f"a part of a register, at {state.at:#x}")
                    found = {} if size == 16 else 0
                return self._operations.typed(found, expression.ty)
            case "Iex_Load":
                at = self._integer(expression.addr, state, types)
                return self._operations.typed(
                    self._read(state.memory, at, size_of(expression.ty)), expression.ty
                )
            case "Iex_ITE":
                condition, a, b = (
                    self._value(each, state, types)
                    for each in (expression.cond, expression.iftrue, expression.iffalse)
                )
                return self._operations.chosen(condition, a, b, size_of(expression.result_type(types)))
            case "Iex_CCall":
                return self._operations.called(
                    expression.cee.name, [self._value(each, state, types) for each in expression.args]
                )
        operands = [self._value(each, state, types) for each in expression.args]
        return self._operations.operated(expression.op, operands, expression.result_type(types))

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
