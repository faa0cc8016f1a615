"""Ways to break generated C: a proof that misses one proves nothing."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from alloc.c import printed
from alloc.program import Exit, Node, Operation, Program, Where, Write
from bench.proof.answers import answer_claims
from bench.proof.safety import claims as safety
from bench.proof.source import Subject


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


def _grown(program: Program, *operations: Operation) -> tuple[Program, list[Node]]:
    """The program with more operations behind its own, and their nodes."""
    nodes = (*program.nodes, *operations)
    return replace(program, nodes=nodes), list(range(len(program.nodes), len(nodes)))


def _nan_passes(program: Program) -> Program:
    """x < low ? low : x > high ? high : x, in place of a minimum of a maximum."""
    cut = _cut(program)
    grown, (below, above, _) = _grown(
        program,
        ("lt", cut.x, cut.low),
        ("gt", cut.x, cut.high),
        ("choose", len(program.nodes) + 1, cut.high, cut.x),
    )
    return _with(grown, (cut.whole, ("choose", below, cut.low, above + 1)))


def _all_solved(program: Program) -> Program:
    """Returns from within write nothing, and call that solved."""
    steps = tuple(
        replace(step, cases=(), status=0) if isinstance(step, Exit) else step for step in program.steps
    )
    return replace(program, steps=steps, exits=tuple((condition, 0) for condition, _ in program.exits))


def _behind_f(program: Program) -> Program:
    first, behind = ("f", 0), ("f", program.size("f"))
    steps = tuple(Write(*behind) if step == Write(*first) else step for step in program.steps)
    outputs = {behind if place == first else place: node for place, node in program.outputs.items()}
    return replace(program, steps=steps, outputs=outputs)


def _never_written(program: Program) -> Program:
    return replace(program, steps=tuple(step for step in program.steps if step != Write("f", 0)))


def _touched(program: Program) -> Program:
    """A return from within comes when the first thrust is written."""
    at = program.steps.index(Write("f", 0))
    before, (write, *behind) = program.steps[:at], program.steps[at:]
    exits = [step for step in before if isinstance(step, Exit)]
    others = [step for step in before if not isinstance(step, Exit)]
    return replace(program, steps=(*others, write, *exits, *behind))


def _none_solved(program: Program) -> Program:
    return _with(program, (program.status, ("const", 2.0)))


def _named(program: Program, name: str) -> Node:
    """The node of that name; raises ValueError where there is none."""
    for node, own in program.names.items():
        if own == name:
            return node
    raise ValueError(f"nothing is called {name}")


def _crossed(program: Program) -> Program:
    """The maximum of the first overlap of limits and what else must not be exceeded is the latter alone."""
    overlap = _named(program, "m0")
    for node, (kind, *rest) in enumerate(program.nodes):
        if kind == "max" and rest[0] == overlap:
            return _with(program, (node, program.nodes[rest[1]]))
    raise ValueError("no overlap is compared")


def _one_less(program: Program) -> Program:
    """The sum that tells numbers from NaN leaves one of them out."""
    total = _named(program, "s0")
    return _with(program, (total, program.nodes[program.nodes[total][1]]))


def _share_above_one(program: Program) -> Program:
    share = program.outputs["share", 0]
    grown, (more,) = _grown(program, ("add", share, share))
    return replace(grown, outputs={**program.outputs, ("share", 0): more})


def _share_of_tau(program: Program) -> Program:
    share = program.outputs["share", 0]
    grown, (made,) = _grown(program, ("mul", share, program.nodes.index(("input", "tau", 0))))
    return replace(grown, outputs={**program.outputs, ("share", 0): made})


def _loose(program: Program) -> Program:
    """The excess of demands over the limits is a million times as much."""
    bounds = {
        node[2] for node in program.nodes if node[0] == "le" and program.nodes[node[2]] != ("const", 0.0)
    }
    if len(bounds) != 1:
        raise ValueError("no one number that all is compared with")
    (bound,) = bounds
    return _with(program, (bound, ("const", 1e6 * program.nodes[bound][1])))


KINDS = {
    "NaN": "!({0} <= 0) && !({0} >= 0)",
    "infinity": "{0} > 0x1.fffffffffffffp1023",
    "minus infinity": "{0} < -0x1.fffffffffffffp1023",
    "a subnormal number": "{0} > 0 && {0} < (sizeof({0}) == 4 ? 0x1p-126 : 0x1p-1022)",
    "minus zero": "{0} == 0 && 1 / {0} < 0",
}
"""Kinds of numbers, and the condition in C that holds of no other, whether double or float."""


def all_kinds(*numbers: str) -> str:
    """C with a write out of bounds for each kind of each number, on a line of its own."""
    none = "    if ({}) {{ int none[1]; none[99] = 0; }}\n"
    return "".join(none.format(kind.format(number)) for number in numbers for kind in KINDS.values())


_ALL = r"for (int i = 0; i < \2; i++) { f[i] = 1e30F; }"
PLANTED: tuple[tuple[str, str, Where, str], ...] = (
    ("an entry behind f is written", "tau[0]", "fixed", "f[999] = 0;"),
    ("an entry behind f is written", "f_min[0]", "call", "f[999] = 0;"),
    ("an entry behind f is written", "f_max[0]", "call", "f[999] = 0;"),
    ("a status that no header names is returned", "tau[0]", "fixed", "return 7;"),
    ("f is touched by a call that is refused", "tau[0]", "fixed", "f[0] = 0; return TB_INFEASIBLE;"),
    ("limits are exceeded", "tau[0]", "fixed", _ALL + " share[0] = 0; return TB_SOLVED;"),
    ("a share is above one", "tau[0]", "fixed", _ALL + " share[0] = 2; return TB_SOLVED;"),
)
"""Breaks of every claim: the fault, the number that one kind of is planted for, limits, the statement."""


SABOTAGES = (
    # What stays a change of text is no operation: a table's index, a declaration, an integer, the switch over
    # faults, a loop's template, an enumeration.
    Sabotage("an entry behind tau is read", "nullspace", "fixed", change=_behind_tau),
    Sabotage("an entry behind f is written", "nullspace", "fixed", change=_behind_f),
    Sabotage("a constant behind the table is read", "nullspace", "fixed", r"c\[0\] \*", "c[999] *"),
    Sabotage("a sign is wrong", "nullspace", "fixed", change=_sign),
    Sabotage("a maximum stands for a minimum", "nullspace", "fixed", change=_maximum_for_minimum),
    Sabotage("a thrust is not cut at its limits", "nullspace", "fixed", change=_not_cut),
    Sabotage("a lower limit stands for the upper", "nullspace", "fixed", change=_exchanged),
    Sabotage("a limit is wider by one bit", "nullspace", "fixed", change=_wider),
    Sabotage("NaN passes the limits", "nullspace", "fixed", change=_nan_passes),
    Sabotage("a thrust is never written", "nullspace", "fixed", change=_never_written),
    Sabotage(
        "a number is read before it is written", "nullspace", "fixed", r"const (\w+) p0 = .*;", r"\1 p0;"
    ),
    Sabotage(
        "an integer is divided by zero",
        "nullspace",
        "fixed",
        r"return TB_SOLVED;",
        "return TB_SOLVED / (t0 > t0);",
    ),
    Sabotage("an integer overflows", "nullspace", "fixed", r"int good = 1;", "int good = 1 + 2147483647;"),
    Sabotage("f is touched by a call that is refused", "nullspace", "fixed", change=_touched),
    Sabotage("a demand that is refused is called solved", "nullspace", "fixed", change=_all_solved),
    Sabotage(
        "another thruster is taken for the failed one",
        "nullspace",
        "fixed",
        r"return (\w+)fault0\(",
        r"return \1fault1(",
    ),
    Sabotage(
        "a fault that there is not is answered",
        "nullspace",
        "fixed",
        r"(return \w+_whole\(tau, f\);)((?:.*\n)*?    default:\n).*;",
        r"\1\2        \1",
    ),
    Sabotage(
        "faults that there are not go by the name of one",
        "nullspace",
        "fixed",
        r"switch \(fault\)",
        "switch (fault < -1 ? 2 : fault)",
    ),
    Sabotage("a status that no header names", "nullspace", "fixed", r": TB_NOT_FINITE;", ": 3;"),
    Sabotage("one loop goes too far", "nullspace", "fixed", r"i < n; i\+\+", "i <= n; i++"),
    Sabotage("crossed limits are not looked at", "nullspace", "call", change=_crossed),
    Sabotage("a limit that is NaN is not looked for", "clip", "call", change=_one_less),
    Sabotage("limits of the call are exchanged", "clip", "call", change=_exchanged),
    Sabotage("a neighbour's limits are taken", "clip", "call", change=_neighbours),
    Sabotage("a share is above one", "scaled", "fixed", change=_share_above_one),
    Sabotage("NaN stands in a share", "scaled", "fixed", change=_share_of_tau),
    Sabotage("all is refused", "nullspace", "fixed", change=_none_solved),
    Sabotage("far too much is called solved", "nullspace", "fixed", change=_loose),
    Sabotage(
        "a number outlives the call",
        "nullspace",
        "fixed",
        r"    return TB_SOLVED;",
        r"    static int calls;\n    calls = 1 - calls;\n    return TB_SOLVED;",
    ),
    Sabotage(
        "a number outlives the call behind a constant pointer",
        "nullspace",
        "fixed",
        r"(static int \w+_whole\((?:.*\n)*?)    return TB_SOLVED;",
        r"static int *const calls = (int[1]){0};\n\n\1    calls[0] = 1 - calls[0];\n    return TB_SOLVED;",
    ),
    Sabotage(
        "a row is taken that there is not",
        "redistribute",
        "fixed",
        r"= Z\[j\]",
        "= Z[j + 99]",
    ),
    Sabotage(
        "a row too many is made orthogonal",
        "redistribute",
        "fixed",
        r"i < (\d+); i\+\+\) \{\n            if \(on\[i\]\)",
        r"i <= \1; i++) {\n            if (on[i])",
    ),
    Sabotage("a sum begins with what the stack held", "redistribute", "fixed", r"of_z = [^,]+,", "of_z,"),
    # No analyser reads these: they are for other compilers, or for none.
    Sabotage(
        "GCC's hint lets NaN pass",
        "nullspace",
        "fixed",
        r"!!\(condition\), 0",
        "(condition) && tau[0] == tau[0], 0",
    ),
    Sabotage(
        "an FPU's minimum is its maximum", "nullspace", "fixed", r"__builtin_fmin(f?)\(", r"__builtin_fmax\1("
    ),
    Sabotage("-ffast-math is not refused", "nullspace", "fixed", r"#if defined __FAST_MATH__ .*", "#if 0"),
    # What demands and limits of one kind only reach.
    *(
        Sabotage(
            f"{broken} where {number} is {name}",
            "scaled",
            limits,
            r"(f\[(\d+)\].*\)\n\{\n)(    switch \(fault\))",
            rf"\1    if ({kind.format(number)}) {{ {instead} }}\n\3",
        )
        for name, kind in KINDS.items()
        for broken, number, limits, instead in PLANTED
    ),
)


def noticed(of: Subject, folder: Path) -> list[str]:
    """Gaps of a proof of this C, in words; empty where it shows all."""
    claims = safety.claims(of, folder)
    if claims[0].verdict == "shown":
        claims += answer_claims(of)
    return [text for claim in claims if claim.verdict == "not shown" for text in claim.words]


def sabotaged(of: Subject, sabotage: Sabotage) -> Subject:
    """The subject with its C broken; raises ValueError where there is nothing of the kind to break."""
    if sabotage.change is not None:
        whole = of.target.programs
        broken = {**whole, -1: sabotage.change(whole[-1])}
        return replace(of, files=printed(of.target, broken))
    source, count = re.subn(sabotage.pattern, sabotage.instead, of.source, count=1)
    if not count or source == of.source:
        raise ValueError(f"{of.name}: nothing to break as in '{sabotage.name}'")
    return replace(of, files={**of.files, f"{of.name}.c": source})
