"""Conversions by C's types: a number of another type than the kernel's own would be rounded."""

from collections.abc import Sequence
from typing import Any

from pycparser import c_ast

from alloc.program import Node, Operation, Scalar
from bench.proof.not_read import NotRead
from bench.proof.parsed import table

_TRUTHS = {"lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not"}


def constants(declared: c_ast.Decl, scalar: Scalar) -> Any:
    """Numbers that a constant array holds, or rows of them; raises NotRead where its type rounds them."""
    of = declared.type
    while isinstance(of, c_ast.ArrayDecl):
        of = of.type
    if of.type.names != [scalar] and {"float", "double"} & set(of.type.names):
        raise NotRead(f"a table in {' '.join(of.type.names)}")
    return table(declared.init)


def held(declared: Any, value: Any, nodes: Sequence[Operation], scalar: Scalar) -> Any:
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
