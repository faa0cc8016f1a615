"""A program as C statements: each number that has a name, or is needed twice, in a line of its own."""

from collections import Counter
from collections.abc import Iterable
from itertools import chain

from alloc.c.text import CALLED, c_function
from alloc.program import (
    Branch,
    DataLoop,
    Exit,
    Fence,
    Node,
    Program,
    Scalar,
    Step,
    Write,
    every,
    named,
    operands,
)
from alloc.program.literal import number

NO_SUCH_FAULT = -1
"""Status of a kernel for a fault that it has no code for."""
STATUSES = {
    0: "TB_SOLVED",
    1: "TB_PARTIAL",
    2: "TB_INFEASIBLE",
    3: "TB_NOT_CONVERGED",
    NO_SUCH_FAULT: "TB_NO_SUCH_FAULT",
    -2: "TB_NOT_FINITE",
}
"""Names of the statuses in C."""
STATUS_ENUM = f"""\
#ifndef THRUSTBENCH_STATUSES
#define THRUSTBENCH_STATUSES
enum {{ {", ".join(f"{word} = {value}" for value, word in STATUSES.items())} }};
#endif"""
"""C that defines these names, once in a translation unit."""
BINARY = {
    "add": ("+", 4), "sub": ("-", 4), "mul": ("*", 5), "div": ("/", 5),
    "lt": ("<", 3), "le": ("<=", 3), "gt": (">", 3), "ge": (">=", 3), "eq": ("==", 3), "ne": ("!=", 3),
    "and": ("&", 1), "or": ("|", 1),
}  # fmt: skip
"""C's operator of an operation, and how tightly it binds."""
CONDITIONS = ("lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not", "finite")
ALONE, SIGNED, CONDITION, TERNARY = 7, 6, 2, 0
"""Precedences of a name or a call, a sign, the condition of a ternary (with brackets around & and |,
without which Clang warns), and a ternary."""


class Table:
    """The constants of one function, each held once; the C refers to them as ``c[i]``."""

    def __init__(self, scalar: Scalar) -> None:
        """An empty table of that type."""
        self.scalar = scalar
        self._index: dict[str, int] = {}
        self._columns: dict[tuple[str, ...], int] = {}

    def __call__(self, value: float) -> str:
        """The C expression for a constant; its sign stands in front, so that +-x share an entry."""
        if value == 0.0:
            return number(0.0, self.scalar)
        entry = self._index.setdefault(number(abs(value), self.scalar), len(self._index))
        return f"{'-' if value < 0 else ''}c[{entry}]"

    def by_fault(self, values: tuple[float, ...]) -> str:
        """The C expression for a constant that each fault has its own of, in the row of the fault."""
        column = tuple(number(value, self.scalar) for value in values)
        return f"of[{self._columns.setdefault(column, len(self._columns))}]"

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Constants that differ between faults, a row a fault; empty where nothing differs."""
        return list(zip(*self._columns, strict=True))

    def define(self) -> list[str]:
        """The lines that define the table; none where it is empty."""
        values = ",\n    ".join(self._index)
        return [f"static const {self.scalar} c[] = {{\n    {values}\n}};"] if values else []


class Statements:
    """The statements of one program.

    Attributes
    ----------
    lines : the statements
    table : the constants that they refer to
    """

    def __init__(self, program: Program, own: str) -> None:
        """Write the program of one call; names of its loops' functions begin with ``own``."""
        self.own = own
        self.program, self.table, self.lines = program, Table(program.scalar), list[str]()
        self._names: dict[Node, str] = {}
        self._taken: set[str] = {"c", "f", "tau", "f_min", "f_max", "share", "fault", "working", "of"}
        asked = (named(step, program) for step in every(program.steps))
        self._uses = Counter([program.status, *chain.from_iterable(asked)])  # how often C names each node
        # What stands in an arm of a ternary is calculated behind a jump, which costs more than both arms.
        self._arms = {
            each
            for step in program.steps
            if isinstance(step, int) and program.nodes[step][0] == "choose"
            for each in operands(program.nodes[step])[1:]
        }
        self._printed: Counter[Node] = Counter()
        self._looped: dict[str, str] = {}
        self._assigned: set[Node] = set()
        self._block(program.steps)
        self.finish()

    refused = ""
    """Text before the status in a form that leaves nowhere but at its end."""

    def finish(self) -> None:
        """The last statement."""
        self.lines.append(f"return {self.status(self.program.status)};")

    # Subclasses, which print other forms of a program, override what follows.

    def argument(self, array: str, index: int) -> str:
        """An entry of an argument."""
        return f"{array}[{index}]"

    def fence(self, step: Fence) -> None:
        """A fence."""
        self.lines.append("tb_fence();")

    def write(self, step: Write) -> None:
        """An output."""
        value = self.expression(self.program.outputs[step.array, step.index])
        self.lines.append(f"{step.array}[{step.index}] = {value};")

    def leave(self, step: Exit) -> None:
        """A return from within."""
        condition = self.expression(step.condition)
        cases = "".join(
            f"{self.expression(case, CONDITION)} ? {STATUSES[status]} : " for case, status in step.cases
        )
        self.lines += [
            f"if (tb_unlikely({condition})) {{" if step.unlikely else f"if ({condition}) {{",
            f"    return {cases}{STATUSES[step.status]};",
            "}",
        ]

    def _block(self, steps: Iterable[Step]) -> None:
        for step in steps:
            match step:
                case int():
                    self._define(step)
                case Fence():
                    self.fence(step)
                case Write():
                    self.write(step)
                case Exit():
                    self.leave(step)
                case Branch():
                    self.branch(step)

    def status(self, node: Node) -> str:
        """The expression of a status."""
        match self.program.nodes[node]:
            case ("const", value):
                return STATUSES[int(value)]
            case ("choose", condition, a, b):
                return f"{self.expression(condition, CONDITION)} ? {self.status(a)} : {self.status(b)}"
        raise AssertionError(self.program.nodes[node])

    def _define(self, node: Node) -> None:
        """A line of its own for a node that has a name or is needed more than once."""
        operation = self.program.nodes[node]
        kind = operation[0]
        if kind == "loop":
            self._loop(self.program.loops[operation[1]], operation[3])
        elif kind not in ("const", "by_fault") and (
            node in self.program.names
            or self._uses[node] > 1
            or node in self._arms
            or kind in ("input", "again")
        ):
            of = "int" if kind in CONDITIONS else self.program.scalar
            value = self.expression(node)
            self._names[node] = self._new(self.program.names.get(node, f"n{node}"))
            self.lines.append(f"const {of} {self._names[node]} = {value};")

    def _new(self, name: str) -> str:
        """The name, with a number behind it where another node has it."""
        found, i = name, 1
        while found in self._taken:
            found, i = f"{name}_{i}", i + 1
        self._taken.add(found)
        return found

    def branch(self, step: Branch) -> None:
        """Steps under a condition."""
        outside, self.lines = self.lines, []
        condition = self.expression(step.condition)
        self._block(step.steps)
        before, then = list[str](), list[str]()
        for node in step.merged:
            _, _, new, old = self.program.nodes[node]
            value = self.expression(new)
            # The old value's variable takes the new one where nothing else reads the old one.
            if old in self._assigned and self._printed[old] == self._uses[old] - 1:
                self._names[node] = self._names[old]
            else:
                self._names[node] = self._new(self.program.names.get(node, f"n{node}"))
                before.append(f"{self.program.scalar} {self._names[node]} = {self.expression(old)};")
            self._assigned.add(node)
            then.append(f"{self._names[node]} = {value};")
        inner = [f"    {line}" for line in [*self.lines, *then]]
        asked = f"tb_unlikely({condition})" if step.unlikely else condition
        self.lines = [*outside, *before, f"if ({asked}) {{", *inner, "}"]

    def _loop(self, loop: DataLoop, given: tuple[Node, ...]) -> None:
        if loop.name in self._looped:
            return
        nodes, names = iter(given), list[str]()
        for name, size in loop.arrays:
            entries = [next(nodes) for _ in range(size)]
            read = [self.program.nodes[node] for node in entries]
            whole = next(iter(read))[1] if read else ""
            if read == [("input", whole, i) for i in range(size)]:
                names.append(self.argument(whole, 0).removesuffix("[0]"))  # the argument itself
                continue
            names.append(self._new(name))
            values = ", ".join(self.expression(node) for node in entries)
            self.lines.append(f"{self.program.scalar} {names[-1]}[{size}] = {{{values}}};")
        self._looped[loop.name] = names[-1]
        if loop.flags:
            of, flags = "static const ", [str(each) for each in loop.flags[0]]
            if len(loop.flags) > 1:  # of each fault they stand among its numbers
                columns = (tuple(map(float, each)) for each in zip(*loop.flags, strict=True))
                of, flags = "", [f"{self.table.by_fault(each)} > 0" for each in columns]
            self.lines.append(f"{of}int working[{len(flags)}] = {{{', '.join(flags)}}};")
            names.insert(-1, "working")
        self.lines.append(f"{self.own}{loop.name}({', '.join(names)});")

    def expression(self, node: Node, binds: int = TERNARY) -> str:
        """The C of a node, in brackets where what stands around it binds more tightly."""
        self._printed[node] += 1
        if node in self._names:
            return self._names[node]
        text, tightly = self._written(self.program.nodes[node])
        return f"({text})" if tightly < binds else text

    def _written(self, operation: tuple[object, ...]) -> tuple[str, int]:
        """The C of an operation, and how tightly it binds."""
        match operation:
            case ("const", float(value)):
                return self.table(value), SIGNED if value < 0 else ALONE
            case ("by_fault", tuple(values)):
                return self.table.by_fault(values), ALONE
            case ("input", str(array), int(index)):
                return self.argument(array, index), ALONE
            case ("again", int(inner)):
                _, array, index = self.program.nodes[inner]
                return self.argument(array, index), ALONE
            case ("finite" as kind, str(array), int(first), int(count)):
                return f"{self._function(kind)}({array}{f' + {first}' if first else ''}, {count})", ALONE
            case ("loop", str(name), int(index), _):
                return f"{self._looped[name]}[{index}]", ALONE
            case ("neg", int(a)):
                return f"-{self.expression(a, ALONE)}", SIGNED
            case ("not", int(a)):
                return f"!{self.expression(a, ALONE)}", SIGNED
            case ("choose", int(condition), int(a), int(b)):
                texts = [self.expression(each, TERNARY + 1) for each in (a, b)]
                return "{} ? {} : {}".format(self.expression(condition, CONDITION), *texts), TERNARY
            case ("min", int(inner), int(high)) if self.clamped(inner):
                _, x, low = self.program.nodes[inner]
                texts = [self.expression(each) for each in (x, low, high)]
                return f"{c_function('within', self.program.scalar)}({', '.join(texts)})", ALONE
            case (("min" | "max" | "abs") as kind, *nodes):
                texts = [self.expression(each) for each in nodes if isinstance(each, int)]
                return f"{self._function(kind)}({', '.join(texts)})", ALONE
            case (str(kind), int(a), int(b)) if kind in BINARY:
                sign, tightly = BINARY[kind]
                if kind in ("and", "or"):
                    if self.looks(a) or self.looks(b):  # only where it must
                        sign *= 2
                    # Each condition stands in brackets; without them compilers warn.
                    again = kind == self.program.nodes[a][0]
                    left = self.expression(a, tightly if again else SIGNED)
                    return f"{left} {sign} {self.expression(b, SIGNED)}", tightly
                return f"{self.expression(a, tightly)} {sign} {self.expression(b, tightly + 1)}", tightly
        raise AssertionError(operation)

    def _function(self, kind: str) -> str:
        """The C function of an operation."""
        return c_function(CALLED[kind], self.program.scalar)

    def clamped(self, inner: Node) -> bool:
        """True if a minimum is taken of a maximum that nothing else uses."""
        return inner not in self._names and self.program.nodes[inner][0] == "max"

    def looks(self, node: Node) -> bool:
        """True if a condition reads arguments in a loop."""
        operation = self.program.nodes[node]
        if operation[0] in ("and", "or", "not"):
            return any(self.looks(each) for each in operands(operation))
        return bool(operation[0] == "finite")
