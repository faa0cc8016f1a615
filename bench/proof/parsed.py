"""The generated C as a tree, of functions that a compiler's preprocessor left whole.

Where a preprocessor may leave others (``bench.proof.altered``) the tree is not all that compilers see.
"""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pycparser import c_ast, c_parser
from pycparser.c_parser import ParseError

from alloc.c.compiled import compiler
from alloc.c.statements import STATUSES
from alloc.files.textfile import write_folder
from bench.chips.toolchain import ToolError
from bench.proof import tools
from bench.proof.altered import altered
from bench.proof.not_read import NotRead
from bench.proof.subject import Subject

INCLUDED = "#include <stdint.h>"
INTEGERS = {"int8_t": "signed char", "int16_t": "short", "int32_t": "int"}
SIZED = " ".join(
    f"typedef {own} {name}; typedef unsigned {own.removeprefix('signed ')} u{name};"
    for name, own in INTEGERS.items()
)
"""What is read in place of stdint.h, which only names types."""
NUMBERS = {"int", "float", "double", *INTEGERS, *(f"u{name}" for name in INTEGERS)}


class Unit(NamedTuple):
    """A kernel's C as a tree.

    Attributes
    ----------
    text : all of it
    functions : those that it defines, by name
    cases : the call that answers for each fault
    """

    text: c_ast.FileAST
    functions: dict[str, c_ast.FuncDef]
    cases: dict[int, c_ast.FuncCall]

    @property
    def answering(self) -> set[str]:
        """The functions that return a status to the one that is called, or to another of them."""
        found, waiting = set[str](), [call.name.name for call in self.cases.values()]
        while waiting:
            if (name := waiting.pop()) not in found:
                found.add(name)
                last = self.functions[name].body.block_items[-1]
                if isinstance(last, c_ast.Return) and isinstance(last.expr, c_ast.FuncCall):
                    waiting.append(last.expr.name.name)
        return found

    @property
    def looping(self) -> set[str]:
        """The functions with a loop that data end."""
        return {name for name, function in self.functions.items() if loops(function)}


def read(of: Subject) -> Unit:
    """The kernel's C, parsed; raises NotRead, ToolError without a compiler."""
    if words := altered(of):
        raise NotRead(words)
    return of_one_branch(of)


def of_one_branch(of: Subject) -> Unit:
    """As ``read``, also where other branches for the preprocessor are not those that are printed."""
    text = parsed(of.files, f"{of.name}.c")
    functions = {node.decl.name: node for node in text.ext if isinstance(node, c_ast.FuncDef)}
    return Unit(text, functions, _cases(functions[of.name].body.block_items))


def kept(text: c_ast.FileAST) -> set[str]:
    """The variables of some C that outlive a call and can change."""
    found = {node.name for node in text.ext if _varies(node)}
    waiting: list[Any] = [node for node in text.ext if isinstance(node, c_ast.FuncDef)]
    while waiting:
        node = waiting.pop()
        if _varies(node) and {"static", "extern"} & set(node.storage):
            found.add(node.name)
        waiting += [child for _, child in node.children()]
    return found


def _cases(entry: list[Any]) -> dict[int, c_ast.FuncCall]:
    """The call that answers for each fault; raises NotRead where there is more than a switch over them."""
    match entry:
        case [c_ast.Switch(cond=c_ast.ID(name="fault"), stmt=c_ast.Compound(block_items=[*cases, other]))]:
            pass
        case _:
            raise NotRead("a function that is no switch over fault alone")
    match other:
        case c_ast.Default(stmts=[c_ast.Return(expr=c_ast.ID(name=status))]) if status == STATUSES[-1]:
            pass
        case _:
            raise NotRead(f"a switch that does not end with {STATUSES[-1]} for all other faults")
    found: dict[int, c_ast.FuncCall] = {}
    for case in cases:
        match case:
            case c_ast.Case(stmts=[c_ast.Return(expr=c_ast.FuncCall() as call)]):
                found[int(literal(case.expr))] = call
            case _:
                raise NotRead("a case of a fault that does not return what one call does")
    return found


def parsed(files: Mapping[str, str], name: str) -> c_ast.FileAST:
    """One of the files as a tree, with what it includes of the others; raises NotRead and ToolError."""
    if not compiler():
        raise ToolError("needs a C compiler to read C with")
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as place:
        # A compiler's own header has more in it than standard C.
        write_folder(Path(place), {each: text.replace(INCLUDED, SIZED) for each, text in files.items()})
        flags = ["-E", "-P", "-std=c99", "-U__GNUC__", "-U__ARM_FP"]
        text = tools.run([*compiler(), *flags, name], Path(place))
    try:
        return c_parser.CParser().parse(text)
    except ParseError as error:
        raise NotRead(f"no C: {error}") from None


def literal(node: Any) -> float:
    """The number that a constant stands for; raises NotRead."""
    if isinstance(node, c_ast.UnaryOp) and node.op == "-":
        return -literal(node.expr)
    if not isinstance(node, c_ast.Constant):
        raise NotRead(f"{type(node).__name__} where a number should stand")
    text = node.value.rstrip("FfLlUu")
    return float(np.float32(text)) if node.value[-1] in "Ff" else float(text)


def table(node: Any) -> Any:
    """Numbers, or rows of them."""
    return tuple(map(table, node.exprs)) if isinstance(node, c_ast.InitList) else literal(node)


def _varies(node: Any) -> bool:
    """True if this declares a variable that is no constant number, or array of them.

    What a pointer points at may change, however constant the pointer is.
    """
    if not isinstance(node, c_ast.Decl) or isinstance(node.type, c_ast.FuncDecl | c_ast.Enum):
        return False
    if node.name is None:  # a struct's type, and no variable of it
        return False
    of = node.type
    while isinstance(of, c_ast.ArrayDecl):
        of = of.type
    match of:
        case c_ast.TypeDecl(quals=quals, type=c_ast.IdentifierType(names=[name])) if name in NUMBERS:
            return "const" not in quals
    return True


def loops(function: c_ast.FuncDef) -> bool:
    """True if a function has a loop that data end: with while, break, or a return inside."""
    found: list[tuple[Any, bool]] = [(function.body, False)]
    while found:
        node, inside = found.pop()
        ends = isinstance(node, c_ast.Break | c_ast.Return) and inside
        if ends or isinstance(node, c_ast.While | c_ast.DoWhile):
            return True
        found += [(child, inside or isinstance(node, c_ast.For)) for _, child in node.children()]
    return False
