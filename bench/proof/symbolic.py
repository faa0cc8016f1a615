"""The generated C read into a program.

Straight code needs no more: functions are inlined, loops between constants written out, an ``if`` that
returns becomes an exit, and one that assigns becomes a choice between two values. What a function writes
whose loops data end is unknown. A number of another type than the kernel's own would be rounded: refused.
"""

from collections.abc import Sequence
from typing import Any

from pycparser import c_ast

from alloc.program import Graph, Node, Operation, Program, Scalar
from bench.proof.source import NotRead, Subject, literal, loops, read, table


def programs(of: Subject) -> dict[int, Program]:
    """Programs of the kernel by fault, -1 for none; raises NotRead, ToolError without a compiler."""
    unit = read(of)
    entry = unit.functions[of.name]
    return {
        fault: _Reader(unit.text, unit.functions, of.scalar).read(entry, fault, call)
        for fault, call in unit.cases.items()
    }


_BINARY = {"+": "add", "-": "sub", "*": "mul", "/": "div", "<": "lt", "<=": "le", ">": "gt", ">=": "ge"}
_BINARY |= {"==": "eq", "!=": "ne", "&&": "and", "||": "or", "&": "and", "|": "or"}
_UNARY = {"-": "neg", "!": "not"}


def _declare(name: str, value: Any, names: dict[str, Any]) -> None:
    """A new name; raises NotRead where it would hide one, which is another variable then."""
    if name in names:
        raise NotRead(f"{name} is declared where it is known already")
    names[name] = value


class _Reader:
    """Reads one function and all that it calls into one program."""

    def __init__(self, unit: c_ast.FileAST, functions: dict[str, c_ast.FuncDef], scalar: Scalar) -> None:
        self.functions, self.scalar = functions, scalar
        self.graph = Graph()
        self.exits: list[tuple[Node, int]] = []
        self.constants: dict[str, Any] = {}
        for node in unit.ext:
            if isinstance(node, c_ast.Decl) and isinstance(node.type, c_ast.Enum):
                for each in node.type.values.enumerators:
                    self.constants[each.name] = self.const(literal(each.value))
            elif isinstance(node, c_ast.Decl) and isinstance(node.init, c_ast.InitList):
                self.constants[node.name] = constants(node, self.scalar)

    def const(self, value: float) -> Node:
        return self.graph.add("const", value)

    def unknown(self) -> Node:
        return self.graph.add("unknown", len(self.graph.nodes))

    def read(self, entry: c_ast.FuncDef, fault: int, call: c_ast.FuncCall) -> Program:
        """Effect of a called function where it comes to this call, of one fault."""
        names: dict[str, Any] = dict(self.constants)
        arrays: list[Any] = []
        for parameter in entry.decl.type.args.params:
            if not isinstance(parameter.type, c_ast.ArrayDecl):
                names[parameter.name] = self.const(fault)
                continue
            arrays.append(parameter)
            size = int(literal(parameter.type.dim))
            written = "const" not in parameter.type.type.quals
            names[parameter.name] = [
                None if written else self.graph.add("input", parameter.name, i) for i in range(size)
            ]
        status = self.value(call, names)
        outputs: dict[tuple[str, int], Node] = {}
        for parameter in arrays:
            if "const" not in parameter.type.type.quals:
                for i, value in enumerate(names[parameter.name]):
                    if value is None:
                        raise NotRead(f"{parameter.name}[{i}] is never written")
                    outputs[parameter.name, i] = value
        return Program(nodes=tuple(self.graph.nodes), exits=tuple(self.exits), outputs=outputs, status=status)

    def block(self, statements: list[Any], names: dict[str, Any], under: Node | None) -> Node:
        """Read statements; returns what is returned at their end, or -1."""
        for statement in statements or []:
            match statement:
                case c_ast.Return():
                    returned: Node = self.value(statement.expr, names)
                    return returned
                case c_ast.Decl() | c_ast.DeclList():
                    for each in getattr(statement, "decls", [statement]):
                        _declare(each.name, self.declared(each, names), names)
                case c_ast.Assignment() if statement.op == "=":
                    self.assign(statement.lvalue, self.value(statement.rvalue, names), names)
                case c_ast.Assignment() if statement.op == "&=":
                    name = statement.lvalue.name
                    names[name] = self.graph.add("and", names[name], self.value(statement.rvalue, names))
                case c_ast.For():
                    self.repeat(statement, names)
                case c_ast.If():
                    self.branch(statement, names, under)
                case c_ast.FuncCall():
                    self.value(statement, names)
                case c_ast.Cast(expr=c_ast.ID() | c_ast.Constant()) | c_ast.EmptyStatement():
                    pass
                case c_ast.Compound(block_items=None):
                    pass
                case _:
                    raise NotRead(f"{type(statement).__name__} in straight code")
        return -1

    def declared(self, statement: c_ast.Decl, names: dict[str, Any]) -> Any:
        if isinstance(statement.type, c_ast.ArrayDecl):
            if statement.init is None:
                return [None] * int(literal(statement.type.dim))
            if "const" in statement.type.type.quals:
                return constants(statement, self.scalar)
            return [self.value(each, names) for each in statement.init.exprs]
        return (
            None
            if statement.init is None
            else self.of_type(statement.type, self.value(statement.init, names))
        )

    def of_type(self, declared: Any, value: Any) -> Any:
        return type_value(declared, value, self.graph.nodes, self.scalar)

    def repeat(self, statement: c_ast.For, names: dict[str, Any]) -> None:
        """A loop from one constant to another, one by one, written out."""
        (counter,) = statement.init.decls
        goes = statement.cond.op, getattr(statement.next, "op", None)
        step = getattr(statement.next, "expr", None)
        counted = [getattr(node, "name", None) for node in (statement.cond.left, step)]
        if goes != ("<", "p++") or counted != [counter.name] * 2:
            raise NotRead(f"a loop that is none of {counter.name} < …; {counter.name}++")
        begin, end = (self.constant(each, names) for each in (counter.init, statement.cond.right))
        for i in range(begin, end):
            inner = dict(names)
            _declare(counter.name, self.const(i), inner)
            self.block(statement.stmt.block_items, inner, None)
            if inner[counter.name] != self.const(i):
                raise NotRead("a loop that writes its counter")
            names.update({name: inner[name] for name in names})

    def constant(self, node: Any, names: dict[str, Any]) -> int:
        if isinstance(node, c_ast.BinaryOp) and node.op == "+":
            return self.constant(node.left, names) + self.constant(node.right, names)
        operation = self.graph.nodes[self.value(node, names)]
        if operation[0] != "const":
            raise NotRead("an index that is calculated")
        return int(operation[1])

    def element(self, node: c_ast.ArrayRef, names: dict[str, Any]) -> tuple[Any, int]:
        """An array, and the index in it that is written or read."""
        array, index = names.get(getattr(node.name, "name", "")), self.constant(node.subscript, names)
        if not isinstance(array, list | tuple):
            raise NotRead("an entry of what is no array that is known")
        if not 0 <= index < len(array):
            raise NotRead(f"{node.name.name}[{index}] lies behind the array's end")
        return array, index

    def assign(self, place: Any, value: Node, names: dict[str, Any]) -> None:
        if isinstance(place, c_ast.ID):
            names[place.name] = value
        elif isinstance(place, c_ast.ArrayRef):
            array, index = self.element(place, names)
            array[index] = value
        else:
            raise NotRead(f"an assignment to {type(place).__name__}")

    def branch(self, statement: c_ast.If, names: dict[str, Any], under: Node | None) -> None:
        condition = self.value(statement.cond, names)
        held = condition if under is None else self.graph.add("and", under, condition)
        inner = {name: list(value) if isinstance(value, list) else value for name, value in names.items()}
        then = statement.iftrue
        body = then.block_items if isinstance(then, c_ast.Compound) else [then]
        returned = self.block(body, inner, held)
        if statement.iffalse is not None:
            raise NotRead("else in straight code")
        if returned >= 0:
            self.exit(held, returned)
            return
        for name, before in names.items():
            after = inner[name]
            if isinstance(before, list):
                for i, (old, new) in enumerate(zip(before, after, strict=True)):
                    if old != new:
                        before[i] = self.graph.add("choose", condition, new, old)
            elif before != after:
                names[name] = self.graph.add("choose", condition, after, before)

    def exit(self, held: Node, returned: Node) -> None:
        """A return under a condition; of two that a ternary gives, each under its own."""
        operation = self.graph.nodes[returned]
        if operation[0] == "const":
            self.exits.append((held, int(operation[1])))
        elif operation[0] == "choose":
            _, condition, then, other = operation
            self.exit(self.graph.add("and", held, condition), then)
            self.exit(held, other)
        else:
            raise NotRead("a status that is calculated")

    def value(self, node: Any, names: dict[str, Any]) -> Any:
        match node:
            case c_ast.Constant():
                return self.const(literal(node))
            case c_ast.ID():
                if names.get(node.name) is None:
                    raise NotRead(f"{node.name} is read and was never written")
                return names[node.name]
            case c_ast.ArrayRef():
                array, index = self.element(node, names)
                found = array[index]
                if isinstance(found, tuple):  # a row of a table
                    return found
                if isinstance(found, float):
                    return self.const(found)
                if found is None:
                    raise NotRead(f"{node.name.name}[…] is read and was never written")
                return found
            case c_ast.BinaryOp():
                return self.binary(node, names)
            case c_ast.UnaryOp():
                return self.unary(node, names)
            case c_ast.TernaryOp():
                parts = node.cond, node.iftrue, node.iffalse
                return self.ternary(*(self.value(each, names) for each in parts))
            case c_ast.FuncCall():
                return self.call(node.name.name, [self.value(each, names) for each in node.args.exprs])
        raise NotRead(f"{type(node).__name__} in an expression")

    def binary(self, node: c_ast.BinaryOp, names: dict[str, Any]) -> Any:
        left, right = self.value(node.left, names), self.value(node.right, names)
        if isinstance(left, list):
            return left[int(self.graph.nodes[right][1]) :]  # a pointer moved along its array
        return self.graph.add(_BINARY[node.op], left, right)

    def unary(self, node: c_ast.UnaryOp, names: dict[str, Any]) -> Node:
        operand = self.value(node.expr, names)
        inner = self.graph.nodes[operand]
        if node.op not in _UNARY:
            raise NotRead(f"the operator {node.op}")
        if node.op == "-" and inner[0] == "const":
            return self.const(-inner[1])
        return self.graph.add(_UNARY[node.op], operand)

    def ternary(self, condition: Node, then: Node, other: Node) -> Node:
        nodes = self.graph.nodes
        match nodes[condition]:
            case ("lt", a, b) if (a, b) == (then, other):
                return self.graph.add("min", then, other)
            case ("gt", a, b) if (a, b) == (then, other):
                return self.graph.add("max", then, other)
            case ("lt", a, b) if nodes[b] == ("const", 0.0) and nodes[then] == ("neg", a) and a == other:
                return self.graph.add("abs", a)
        return self.graph.add("choose", condition, then, other)

    def call(self, name: str, given: list[Any]) -> Any:
        function = self.functions.get(name)
        if function is None:
            raise NotRead(f"a call of {name}, which is not in the file")
        parameters = function.decl.type.args.params
        if loops(function):
            for parameter, value in zip(parameters, given, strict=True):
                if isinstance(value, list) and "const" not in parameter.type.type.quals:
                    value[:] = [self.unknown() for _ in value]
            return self.unknown()
        inner = dict(self.constants)
        inner |= {
            parameter.name: self.of_type(parameter.type, value)
            for parameter, value in zip(parameters, given, strict=True)
        }
        return self.of_type(function.decl.type.type, self.block(function.body.block_items, inner, None))


_TRUTHS = {"lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not"}


def constants(declared: c_ast.Decl, scalar: Scalar) -> Any:
    """Numbers that a constant array holds, or rows of them; raises NotRead where its type rounds them."""
    of = declared.type
    while isinstance(of, c_ast.ArrayDecl):
        of = of.type
    if of.type.names != [scalar] and {"float", "double"} & set(of.type.names):
        raise NotRead(f"a table in {' '.join(of.type.names)}")
    return table(declared.init)


def type_value(declared: Any, value: Any, nodes: Sequence[Operation], scalar: Scalar) -> Any:
    """Value that a variable, a parameter or a function of that type holds; raises NotRead.

    A type other than the kernel's own would round it, an int cut what is behind its point.
    """
    kinds = getattr(declared.type, "names", None)
    if kinds == ["void"]:
        return value
    if isinstance(value, int) and kinds not in (["int"], [scalar]):
        raise NotRead(f"a number in {' '.join(kinds or ['no number'])}")
    if isinstance(value, int) and kinds == ["int"] and not _whole(nodes, value):
        raise NotRead("a number in an int")
    return value


def _whole(nodes: Sequence[Operation], value: Node) -> bool:
    """True if a value is one of a few whole numbers: a truth, a constant, a choice between such."""
    kind, *rest = nodes[value]
    if kind == "choose":
        return _whole(nodes, rest[1]) and _whole(nodes, rest[2])
    return kind in _TRUTHS or kind == "unknown" or (kind == "const" and float(rest[0]).is_integer())
