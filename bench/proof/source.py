"""Generated C that claims speak of: its text, its tree, and what preprocessors may make of it.

The tree is of functions that a compiler's preprocessor left whole. Compilers differ in it: where one may
leave others (``preprocessor_change``) the tree is not all that compilers see.
"""

import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pycparser import c_ast, c_parser
from pycparser.c_parser import ParseError

from alloc import Vehicle
from alloc.c import Target, sources
from alloc.c.compiled import compiler
from alloc.c.statements import STATUSES
from alloc.files.textfile import write_folder
from alloc.methods import recipe
from alloc.program import Faults, Scalar, Where
from bench.chips.toolchain import ToolError
from bench.proof import tools
from bench.proof.proof import Claim, unproved

ANSWERED = (0, 1)
"""Statuses of a kernel with an answer: SOLVED and PARTIAL."""
INCLUDED = "#include <stdint.h>"
INTEGERS = {"int8_t": "signed char", "int16_t": "short", "int32_t": "int"}
SIZED = " ".join(
    f"typedef {own} {name}; typedef unsigned {own.removeprefix('signed ')} u{name};"
    for name, own in INTEGERS.items()
)
"""Text in place of stdint.h, which only names types."""
NUMBERS = {"int", "float", "double", *INTEGERS, *(f"u{name}" for name in INTEGERS)}
_COMMENT_OR_TEXT = re.compile(
    r"""/\*.*?\*/|//[^\r\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""", flags=re.DOTALL
)
_MEANT = re.compile(r"#|%:|\?\?|\\[ \t]+$|\b_[A-Z_]")
"""Text with a meaning to a preprocessor: directives, digraphs, trigraphs, a line that goes on for some, and
words that compilers reserve, such as _Pragma and macros of their own."""
_NESTED = re.compile(r"\s*#\s*(if|endif)")


class NotRead(Exception):
    """Error of an analysis that can't follow C, or a program; the message says what it can't."""


@dataclass(frozen=True, kw_only=True)
class Subject:
    """Subject of a proof: the C of one method for one vehicle.

    Attributes
    ----------
    vehicle, kernel, scalar, limits, faults : as ``alloc.c.sources`` takes them
    files : that C, by file name
    """

    vehicle: Vehicle
    kernel: str
    scalar: Scalar
    limits: Where
    files: Mapping[str, str]
    faults: Faults = "one"

    @property
    def target(self) -> Target:
        """All that the C was generated for."""
        return Target(
            vehicle=self.vehicle,
            method=recipe(self.kernel),
            scalar=self.scalar,
            limits=self.limits,
            faults=self.faults,
        )

    @property
    def name(self) -> str:
        """The function's name, and stem of its files' names."""
        return self.target.name

    @property
    def source(self) -> str:
        """The text of the C file."""
        return self.files[f"{self.name}.c"]

    @property
    def levels(self) -> int:
        """Number of shares behind f."""
        return self.target.levels

    @property
    def limited(self) -> bool:
        """True if the kernel promises limits."""
        return recipe(self.kernel).limited


def subject(vehicle: Vehicle, kernel: str, scalar: Scalar, limits: Where, faults: Faults = "one") -> Subject:
    """The C that ``thrustbench codegen`` writes; raises UnknownName, or NotApplicable with the reason."""
    target = Target(vehicle=vehicle, method=recipe(kernel), scalar=scalar, limits=limits, faults=faults)
    return Subject(
        vehicle=vehicle, kernel=kernel, scalar=scalar, limits=limits, faults=faults, files=sources(target)
    )


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
    if words := preprocessor_change(of):
        raise NotRead(words)
    return of_one_branch(of)


def of_one_branch(of: Subject) -> Unit:
    """As ``read``, also where other branches for the preprocessor are not those that are printed."""
    text = parsed(of.files, f"{of.name}.c")
    functions = {node.decl.name: node for node in text.ext if isinstance(node, c_ast.FuncDef)}
    return Unit(text, functions, _cases(functions[of.name].body.block_items))


def static_variables(text: c_ast.FileAST) -> set[str]:
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


def preprocessor_change(of: Subject) -> str:
    """The first line of this that is another than the one that is printed, in words; empty if none is."""
    made = subject(of.vehicle, of.kernel, of.scalar, of.limits, of.faults).files
    for name in sorted({*made, *of.files}):
        for usual, found in zip_longest(
            preprocessor_lines(made.get(name, "")), preprocessor_lines(of.files.get(name, ""))
        ):
            if usual != found:
                return f"{name}: '{found or ''}' is there for '{usual or ''}': compilers may differ in it"
    return ""


def of_all_branches(claims: list[Claim], of: Subject) -> list[Claim]:
    """Claims that one branch shows: not shown where the others are none that are printed."""
    words = preprocessor_change(of)
    return [unproved(each.claim, [words]) if words and each.verdict == "shown" else each for each in claims]


def preprocessor_lines(text: str) -> list[str]:
    """The lines of C that a preprocessor obeys or may change, and all between #if and #endif."""
    lines, inside = list[str](), 0
    for line in _COMMENT_OR_TEXT.sub(_without, text.replace("\\\n", "")).split("\n"):
        nested = _NESTED.match(line)
        inside += nested is not None and nested[1] == "if"
        if line.strip() and (inside or _MEANT.search(line)):
            lines.append(" ".join(line.split()))
        inside -= nested is not None and nested[1] == "endif"
    return lines


def _without(found: re.Match[str]) -> str:
    """A space for a comment; one that may end elsewhere for some stays, as text in quotes does."""
    return found[0] if found[0][0] in "\"'" or re.search(r"\?\?|\\", found[0]) else " "
