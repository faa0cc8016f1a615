"""The C around a kernel for the analyser: a call with any arguments at all, and what must hold after it."""

import re
from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np
from pycparser import c_ast
from pycparser.c_generator import CGenerator

from alloc.c import arguments, covering, known_faults
from alloc.methods import recipe
from alloc.program import Scalar
from bench.proof.source import ANSWERED, NotRead, Subject, literal, parsed

MAIN, ANALYSED = "main.c", "analysed.c"
"""The call of the C, and the C as the analyser reads it: its lines are others than those that are printed."""
CONSTANT = ("of", "low", "high")
"""Arrays of constants, where limits are the vehicle's: ``of`` points at a table."""
REALS = {"double", "float"}
ASSERTED = re.compile(r"asserted\((.*)\);")
SPLIT = "split(k);"
"""A statement where the analyser looks at each value of k apart."""


def harness(of: Subject) -> dict[str, str]:
    """The files to analyse: the C with the covering form of minimum and maximum, and a main that calls it.

    Raises NotRead and ToolError.
    """
    name = f"{of.name}.c"
    known = CONSTANT if of.limits == "fixed" else CONSTANT[:1]
    read = {**of.files, name: covering(of.source, of.scalar)}
    return {ANALYSED: any_bits(read, name, known), MAIN: _main(of)}


def any_bits(files: Mapping[str, str], name: str, known: Collection[str]) -> str:
    """C whose arrays give any bits at each read, and whose other memory is asserted to hold numbers.

    EVA 25 takes for unreachable what follows where a comparison leaves an entry of an array, or what a
    pointer points at, nothing but NaN. Volatile arrays avoid that: they give more than any call can see.
    Members of structures and the arrays that are ``known`` keep their values, so that each is asserted to be
    finite where it is written. Tables, and what scalars hold, are as they are. The C is changed as a tree;
    what writes or points at numbers in a way that is not foreseen raises NotRead. Raises ToolError, too.
    """
    unit = parsed(files, name)
    _AnyBits(unit, known)
    text = CGenerator().visit(unit).replace(SPLIT, "/*@ split k; */")
    return ASSERTED.sub(r"/*@ assert number: \\is_finite(\1); */", text)


class _AnyBits:
    """Changes the tree of some C: see ``any_bits``."""

    def __init__(self, unit: c_ast.FileAST, known: Collection[str]) -> None:
        self._known = known
        structs = [each for each in _nodes(unit, c_ast.Struct) if each.decls]
        self._structs = {each.name: each.decls for each in structs}
        self._fields = [(member.name, member.type) for struct in structs for member in struct.decls]
        for each in _nodes(unit, c_ast.Typedef, c_ast.Union, c_ast.CompoundLiteral):
            if not isinstance(each, c_ast.Typedef) or not _is_integer(each.type):
                raise _refusal(each, f"a {type(each).__name__}, which may hold numbers")
        functions = [each for each in unit.ext if isinstance(each, c_ast.FuncDef)]
        self._parameters = {each.decl.name: _parameters(each.decl) for each in functions}
        declared = [each for each in unit.ext if isinstance(each, c_ast.Decl)]
        prototypes = {each.name: each for each in declared if isinstance(each.type, c_ast.FuncDecl)}
        self._defined = {*self._parameters, *prototypes, "asserted", "split"}
        self._aimed = set[tuple[str, int]]()  # parameters that some call points at an array
        for function in functions:
            self._enter(function)
            self._point(function)
        for function in functions:
            self._enter(function)
            self._arrays(function)
            self._assert(function)
            if prototype := prototypes.get(function.decl.name):
                for each, own in zip(_parameters(prototype), _parameters(function.decl), strict=True):
                    _declared(each.type).quals = _declared(own.type).quals
        for name in prototypes.keys() - self._parameters.keys():  # as its caller's arguments are
            for each in _parameters(prototypes[name]):
                if "const" in _declared(each.type).quals and _is_array(each.type):
                    _declared(each.type).quals.append("volatile")

    def _enter(self, function: c_ast.FuncDef) -> None:
        """Take the declarations of a function; a name may have several in blocks beside each other."""
        self._name = function.decl.name
        found = [each for each in _nodes(function, c_ast.Decl) if "static" not in each.storage]
        self._types = [(each.name, each.type) for each in found]
        self._own = {name for name, of in self._types if _is_array(of)}
        self._passed = {id(each) for node in _nodes(function) for each in _arguments(node)}
        self._passed |= {id(each.field) for each in _nodes(function, c_ast.StructRef)}  # no variable

    def _point(self, function: c_ast.FuncDef) -> None:
        """Refuse pointers at arrays, but for those that are parameters."""
        if isinstance(function.decl.type.type, c_ast.PtrDecl):
            raise _refusal(function, "a function that returns a pointer")
        numbers = {id(each.name) for each in _nodes(function, c_ast.ArrayRef)}

        def at_array(value: Any, but: set[int] = numbers) -> bool:
            return any(each.name in self._own and id(each) not in but for each in _nodes(value, c_ast.ID))

        for node in _nodes(function):
            match node:
                case c_ast.Decl(type=of, init=init) if (
                    init and _is_pointer(of) and at_array(init, numbers | self._passed)
                ):
                    raise _refusal(node, "a pointer at an array")
                case c_ast.Assignment(lvalue=place, rvalue=value) if at_array(value, numbers | self._passed):
                    raise _refusal(node, f"{_text(place)} points at an array")
                case c_ast.FuncCall(name=c_ast.ID(name=name)):
                    parameters = self._parameters.get(name, [])
                    self._aimed |= {
                        (name, i)
                        for i, (each, value) in enumerate(zip(parameters, _arguments(node), strict=False))
                        if _is_pointer(each.type) and at_array(value)
                    }

    def _arrays(self, function: c_ast.FuncDef) -> None:
        """Make arrays volatile that are constant or read, and parameters that point at an array."""
        written = {id(_base(each.lvalue)) for each in _nodes(function, c_ast.Assignment) if each.op == "="}
        used = [each for each in _nodes(function, c_ast.ID) if id(each) not in self._passed | written]
        read = {each.name for each in used}
        aimed = [each for i, each in enumerate(_parameters(function.decl)) if (self._name, i) in self._aimed]
        for each in _nodes(function, c_ast.Decl):
            is_read = "const" in _declared(each.type).quals or each.name in read
            is_array = _is_array(each.type) and "static" not in each.storage and each.name not in self._known
            if (is_array and is_read) or each in aimed:
                _declared(each.type).quals.append("volatile")

    def _assert(self, function: c_ast.FuncDef) -> None:
        """Put assertions behind statements that write numbers elsewhere, and refuse all other writes."""
        asserted = set[int]()
        for block in _nodes(function, c_ast.Compound, c_ast.Case, c_ast.Default):
            key = "block_items" if isinstance(block, c_ast.Compound) else "stmts"
            statements = list[Any]()
            for each in getattr(block, key) or []:
                asserted.add(id(each))
                call = c_ast.ID("asserted")
                statements += [
                    each,
                    *(c_ast.FuncCall(call, c_ast.ExprList([place])) for place in self._places(each)),
                ]
            setattr(block, key, statements)
        for node in _nodes(function):
            if id(node) not in asserted and (places := self._places(node)):
                raise _refusal(node, f"{_text(places[0])} is written inside of a statement")

    def _places(self, node: Any) -> list[Any]:
        """Places that a node itself writes, of numbers that keep their values; raises NotRead."""
        match node:
            case c_ast.Assignment(lvalue=place) if self._is_structure(place):
                raise _refusal(node, f"{_text(place)}, a structure, is written")
            case c_ast.Assignment(lvalue=place) if self._is_number(place):
                return [place]
            case c_ast.UnaryOp(op="&" | "++" | "--" | "p++" | "p--", expr=place) if self._is_number(place):
                raise _refusal(node, f"{_text(node)} may write a number")
            case c_ast.Decl(
                name=name, type=c_ast.TypeDecl(type=c_ast.Struct(name=of)), init=c_ast.InitList()
            ):
                members = [(each.name, each.type) for each in self._structs[of]]
                if not all(_is_real(each) or _is_integer(each) for _, each in members):
                    raise _refusal(node, f"{name} begins with more than numbers")
                numbers = [member for member, each in members if _is_real(each)]
                return [c_ast.StructRef(c_ast.ID(name), ".", c_ast.ID(each)) for each in numbers]
            case c_ast.Decl(type=c_ast.ArrayDecl() as of, init=init) if init and _is_structure(of):
                raise _refusal(node, f"{node.name} begins with structures")
            case c_ast.Decl(name=name, type=c_ast.ArrayDecl(dim=dim), init=init) if (
                init and name in self._known
            ):
                entries = (c_ast.Constant("int", f"{i}") for i in range(int(literal(dim))))
                return [c_ast.ArrayRef(c_ast.ID(name), each) for each in entries]
            case c_ast.FuncCall(name=c_ast.ID(name=name)) if name in self._parameters:
                for each, value in zip(self._parameters[name], _arguments(node), strict=True):
                    known = isinstance(value, c_ast.ID) and value.name in self._own & {*self._known}
                    if known and "const" not in _declared(each.type).quals:
                        raise _refusal(node, f"{value.name} may be written by {name}")
            case c_ast.FuncCall(name=called):
                if _text(called) not in self._defined:
                    raise _refusal(node, f"a call of {_text(called)}, which is not in the file")
        return []

    def _of(self, base: Any) -> list[Any]:
        """The types that a variable, or a member of any structure, of that name has."""
        if isinstance(base, c_ast.StructRef):
            return [of for name, of in self._fields if name == base.field.name]
        return [of for name, of in self._types if isinstance(base, c_ast.ID) and name == base.name]

    def _is_number(self, place: Any) -> bool:
        """True for a number in a structure, in an array that is known, or behind a pointer."""
        base = _base(place)
        if isinstance(base, c_ast.StructRef):
            return any(_is_real(of if base is place else _declared(of)) for of in self._of(base))
        if not isinstance(base, c_ast.ID):
            raise _refusal(place, f"{_text(place)}, a place that is calculated")
        if base is place:
            return False
        return base.name in self._known or any(map(_is_pointer, self._of(base)))

    def _is_structure(self, place: Any) -> bool:
        base = _base(place)
        return any(
            _is_structure(of) and not (base is place and isinstance(of, c_ast.PtrDecl))
            for of in self._of(base)
        )


_text = CGenerator().visit


def _refusal(node: Any, words: str) -> NotRead:
    return NotRead(f"{node.coord}: {words}")


def _nodes(node: Any, *kinds: type) -> Iterator[Any]:
    """A node and all below it, of these kinds if any are given."""
    if not kinds or isinstance(node, kinds):
        yield node
    for _, child in node.children():
        yield from _nodes(child, *kinds)


def _parameters(function: Any) -> list[Any]:
    return function.type.args.params if function.type.args else []


def _arguments(call: Any) -> list[Any]:
    return call.args.exprs if isinstance(call, c_ast.FuncCall) and call.args else []


def _base(place: Any) -> Any:
    """The variable, or member, of which a place is the whole, an entry, or what it points at."""
    while isinstance(place, c_ast.ArrayRef | c_ast.UnaryOp):
        place = place.name if isinstance(place, c_ast.ArrayRef) else place.expr
    return place


def _declared(of: Any) -> c_ast.TypeDecl:
    """The type of what an array or a pointer holds in the end."""
    while not isinstance(of, c_ast.TypeDecl):
        of = of.type
    return of


def _is_real(of: Any) -> bool:
    named = isinstance(of, c_ast.TypeDecl) and isinstance(of.type, c_ast.IdentifierType)
    return named and bool(REALS & {*of.type.names})


def _is_integer(of: Any) -> bool:
    named = isinstance(of, c_ast.TypeDecl) and isinstance(of.type, c_ast.IdentifierType)
    return named and not REALS & {*of.type.names}


def _is_structure(of: Any) -> bool:
    """True for the type of a structure, and of an array of them or a pointer at one."""
    return isinstance(_declared(of).type, c_ast.Struct)


def _is_array(of: Any) -> bool:
    """True for the type of an array of numbers."""
    while isinstance(of, c_ast.ArrayDecl):
        of = of.type
        if _is_real(of):
            return True
    return False


def _is_pointer(of: Any) -> bool:
    return isinstance(of, c_ast.PtrDecl) and _is_real(of.type)


def _main(of: Subject) -> str:
    n, k, levels, call = of.vehicle.n, of.vehicle.k, of.levels, of.limits == "call"
    inputs = [("tau", k), *([("f_min", n), ("f_max", n)] if call else [])]
    outputs = [("f", n), *([("share", levels)] if levels else [])]
    declared = "\n".join(f"    {of.scalar} {name}[{size}];" for name, size in [*inputs, *outputs])
    filled = "\n".join(_loop(size, f"{name}[i] = any;") for name, size in inputs)
    statuses = sorted(recipe(of.kernel).meanings)
    known = [-1, *known_faults(of.vehicle, of.faults).tolist()]
    answered = [status for status in statuses if status in ANSWERED]
    holds = [_each(name, size, "written", f"\\initialized(&{name}[i])") for name, size in outputs]
    if of.limited:
        numbers = outputs[1:] if call else outputs  # bench.proof.safety.limits shows the rest
        holds += [_each(name, size, "number", f"\\is_finite({name}[i])") for name, size in numbers]
        holds += [_each("share", levels, "share", "0 <= share[i] <= 1")] if levels else []
        holds += [] if call else [_limit(of, i) for i in range(n)]
    refused = [_each(name, size, "untouched", f"!\\initialized(&{name}[i])") for name, size in outputs]
    return f"""\
#include "{ANALYSED}"

extern volatile {of.scalar} any;
extern volatile int any_int;

int main(void)
{{
{declared}
    int fault, other, status;
{filled}
    fault = -1; /* each fault apart from the others, and all that are none */
    for (int i = 0; i < {n} && any_int; i++) {{
        fault = i;
    }}
    other = any_int;
    if (other < -1 || other >= {n}) {{
        fault = other;
    }}
    status = {of.name}({arguments(of.limits, levels, "fault")});
    /*@ assert status: {" || ".join(f"status == {each}" for each in statuses)}; */
    /*@ assert status: status == -1 || {" || ".join(f"fault == {each}" for each in known)}; */
    if ({" || ".join(f"status == {each}" for each in answered)}) {{
{chr(10).join(holds)}
    }} else {{
{chr(10).join(refused)}
    }}
    return status;
}}
"""


def _loop(size: int, statement: str) -> str:
    return f"    for (int i = 0; i < {size}; i++) {{\n        {statement}\n    }}"


def _each(name: str, size: int, label: str, holds: str) -> str:
    return _loop(size, f"/*@ assert {label}_{name}: {holds}; */")


def _limit(of: Subject, i: int) -> str:
    low, high = (_exactly(side[i], of.scalar) for side in (of.vehicle.f_min, of.vehicle.f_max))
    off = "" if of.vehicle.readiness[i] == 0 else f"        /*@ assert off: fault != {i} || f[{i}] == 0; */\n"
    # Zero may lie outside of the limits of a thruster that works.
    rests = "" if of.vehicle.f_min[i] <= 0 <= of.vehicle.f_max[i] else f"fault == {i} || "
    return (
        f"        /*@ assert low: {rests}f[{i}] >= {low}; */\n"
        f"        /*@ assert high: {rests}f[{i}] <= {high}; */\n{off}"
    ).rstrip("\n")


def _exactly(value: float, scalar: Scalar) -> str:
    """The real that C's literal of the limit is rounded to: of a decimal ACSL takes the real itself."""
    return float(np.float32(value) if scalar == "float" else value).hex()
