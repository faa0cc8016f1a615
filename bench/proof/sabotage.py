"""Ways to break generated C: a proof that misses one proves nothing."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from alloc.c import printed, programs
from alloc.methods import recipe
from alloc.program import Node, Operation, Program, Where
from bench.proof.rounding.seen import made
from bench.proof.safety import claims as safety
from bench.proof.safety.harness import Subject


class Sabotage(NamedTuple):
    """One change of a kernel: of its program, or of what in its C is no operation.

    Attributes
    ----------
    name : what was broken
    kernel, limits : of which C
    pattern, instead : a regular expression, and what stands in the place of its first match in the C
    change : in their place, a function of the whole vehicle's program that gives a broken one
    """

    name: str
    kernel: str
    limits: Where
    pattern: str = ""
    instead: str = ""
    change: Callable[[Program], Program] | None = None


def _with(program: Program, *changes: tuple[Node, Operation]) -> Program:
    nodes = list(program.nodes)
    for node, operation in changes:
        nodes[node] = operation
    return replace(program, nodes=tuple(nodes))


class _Cut(NamedTuple):
    """A thrust that is cut at its limits, min(max(x, low), high), as nodes."""

    whole: Node
    inner: Node
    x: Node
    low: Node
    high: Node


def _cut(program: Program) -> _Cut:
    """The first thrust that nothing else has cut before; raises ValueError where there is none."""
    nodes = program.nodes
    for (array, _), whole in program.outputs.items():
        match nodes[whole]:
            case ("min", inner, high) if array == "f" and nodes[inner][0] == "max":
                _, x, low = nodes[inner]
                if nodes[x][0] in ("add", "sub", "mul"):
                    return _Cut(whole, inner, x, low, high)
    raise ValueError("no thrust is cut last of all")


def _not_cut(program: Program) -> Program:
    cut = _cut(program)
    return _with(program, (cut.whole, program.nodes[cut.x]))


def _exchanged(program: Program) -> Program:
    cut = _cut(program)
    return _with(program, (cut.inner, ("max", cut.x, cut.high)), (cut.whole, ("min", cut.inner, cut.low)))


def _maximum_for_minimum(program: Program) -> Program:
    cut = _cut(program)
    return _with(program, (cut.whole, ("max", cut.inner, cut.high)))


def _wider(program: Program) -> Program:
    high = _cut(program).high
    return _with(program, (high, ("const", program.nodes[high][1] * (1 + 2.0**-23))))


def _neighbours(program: Program) -> Program:
    cut, nodes = _cut(program), program.nodes
    other = (nodes[cut.high][2] + 1) % program.size("f")
    low, high = (nodes.index(("input", side, other)) for side in ("f_min", "f_max"))
    return _with(program, (cut.inner, ("max", cut.x, low)), (cut.whole, ("min", cut.inner, high)))


def _sign(program: Program) -> Program:
    """The first sum or difference of products is the other one."""
    for node, (kind, *rest) in enumerate(program.nodes):
        if kind in ("add", "sub") and all(program.nodes[each][0] == "mul" for each in rest):
            return _with(program, (node, ("sub" if kind == "add" else "add", *rest)))
    raise ValueError("no sum of products")


def _behind_tau(program: Program) -> Program:
    known = [operation[2] for operation in program.nodes if operation[:2] == ("input", "tau")]
    first = program.nodes.index(("input", "tau", 0))
    return _with(program, (first, ("input", "tau", max(known) + 1)))


SABOTAGES = (
    Sabotage("an entry behind tau is read", "nullspace", "fixed", change=_behind_tau),
    Sabotage("an entry behind f is written", "nullspace", "fixed", r"f\[0\] = ", "f[n] = "),
    Sabotage("a constant behind the table is read", "nullspace", "fixed", r"c\[0\] \*", "c[999] *"),
    Sabotage("a sign is wrong", "nullspace", "fixed", change=_sign),
    Sabotage("a maximum stands for a minimum", "nullspace", "fixed", change=_maximum_for_minimum),
    Sabotage("a thrust is not cut at its limits", "nullspace", "fixed", change=_not_cut),
    Sabotage("a lower limit stands for the upper", "nullspace", "fixed", change=_exchanged),
    Sabotage("a limit is wider by one bit", "nullspace", "fixed", change=_wider),
    Sabotage(
        "NaN passes the limits",
        "nullspace",
        "fixed",
        r"least\(most\(x, low\), high\)",
        r"x < low ? low : x > high ? high : x",
    ),
    Sabotage("a thrust is never written", "nullspace", "fixed", r"    f\[0\] = \w+;\n", ""),
    Sabotage(
        "a number is read before it is written", "nullspace", "fixed", r"const (\w+) p0 = .*;", r"\1 p0;"
    ),
    Sabotage(
        "an integer is divided by zero", "nullspace", "fixed", r"return SOLVED;", "return SOLVED / (t0 > t0);"
    ),
    Sabotage("an integer overflows", "nullspace", "fixed", r"int good = 1;", "int good = 1 + 2147483647;"),
    Sabotage(
        "f is touched by a call that is refused",
        "nullspace",
        "fixed",
        r"(    if \(unlikely)",
        r"    f[0] = t0;\n\1",
    ),
    Sabotage(
        "a demand that is refused is called solved",
        "nullspace",
        "fixed",
        r"return .* \? INFEASIBLE : .*;",
        "return SOLVED;",
    ),
    Sabotage(
        "another thruster is taken for the failed one",
        "nullspace",
        "fixed",
        r"return fault0\(",
        "return fault1(",
    ),
    Sabotage("a status that no header names", "nullspace", "fixed", r"INFEASIBLE = 2", "INFEASIBLE = 3"),
    Sabotage("one loop goes too far", "nullspace", "fixed", r"i < n; i\+\+", "i <= n; i++"),
    Sabotage(
        "crossed limits are not looked at",
        "nullspace",
        "call",
        r"most\(m0, (.*)\) \+ nan_or_zero",
        r"\1 + nan_or_zero",
    ),
    Sabotage("a limit that is NaN is not looked for", "clip", "call", r"(s0 = .*) \+ o\d+;", r"\1;"),
    Sabotage("limits of the call are exchanged", "clip", "call", change=_exchanged),
    Sabotage("a neighbour's limits are taken", "clip", "call", change=_neighbours),
    Sabotage(
        "a share is above one",
        "scaled",
        "fixed",
        r"share0 = (\w+) < (\S+) \? .*;",
        r"share0 = \1 < \2 ? \1 : \1 + \2;",
    ),
    Sabotage(
        "NaN stands in a share",
        "scaled",
        "fixed",
        r"share0 = (\w+) < .*;",
        r"share0 = \1 * t0;",
    ),
    Sabotage(
        "a row is taken that there is not",
        "redistribute",
        "fixed",
        r"order\[rank\] = next",
        "order[rank + 1] = next",
    ),
    Sabotage(
        "a row too many is made orthogonal",
        "redistribute",
        "fixed",
        r"while \(rank < (\d+)\)",
        r"while (rank <= \1)",
    ),
    Sabotage("a sum begins with what the stack held", "redistribute", "fixed", r"rest\[r\] = tau.*;", ";"),
)


def noticed(of: Subject, folder: Path) -> list[str]:
    """What a proof does not show of this C, in words; empty where it shows all."""
    claims = [*safety.claims(of, folder), made(of)]
    return [text for claim in claims if claim.verdict == "not shown" for text in claim.words]


def sabotaged(of: Subject, sabotage: Sabotage) -> Subject:
    """The subject with its C broken; raises ValueError where there is nothing of the kind to break."""
    if sabotage.change is not None:
        kernel = recipe(of.kernel)
        whole = programs(of.vehicle, kernel, of.scalar, limits=of.limits)
        broken = {**whole, -1: sabotage.change(whole[-1])}
        return replace(of, files=printed(of.vehicle, kernel, broken, of.scalar, of.limits))
    instead = re.sub(r"\b([kn])\b(?=\])", lambda size: str(getattr(of.vehicle, size[1])), sabotage.instead)
    source, count = re.subn(sabotage.pattern, instead, of.source, count=1)
    if not count or source == of.source:
        raise ValueError(f"{of.name}: nothing to break as in '{sabotage.name}'")
    return replace(of, files={**of.files, f"{of.name}.c": source})
