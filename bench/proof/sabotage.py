"""Ways to break generated C: a proof that misses one proves nothing."""

import re
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from alloc.program import Where
from bench.proof.rounding.seen import made
from bench.proof.safety import claims as safety
from bench.proof.safety.harness import Subject


class Sabotage(NamedTuple):
    """One change of the C.

    Attributes
    ----------
    name : what was broken
    kernel, limits : of which C
    pattern, instead : a regular expression, and what stands in the place of its first match
    """

    name: str
    kernel: str
    limits: Where
    pattern: str
    instead: str


SABOTAGES = (
    Sabotage("an entry behind tau is read", "nullspace", "fixed", r"= tau\[0\]", "= tau[k]"),
    Sabotage("an entry behind f is written", "nullspace", "fixed", r"f\[0\] = ", "f[n] = "),
    Sabotage("a constant behind the table is read", "nullspace", "fixed", r"c\[0\] \*", "c[999] *"),
    Sabotage(
        "a thrust is not cut at its limits",
        "nullspace",
        "fixed",
        r"(y\d+) = within\((\w+ [-+] .*), \S+, \S+\);",  # steps have cut the others before
        r"\1 = \2;",
    ),
    Sabotage(
        "a lower limit stands for the upper",
        "nullspace",
        "fixed",
        r"y0 = within\((.*), (\S+), (\S+)\);",
        r"y0 = within(\1, \3, \2);",
    ),
    Sabotage(
        "a limit is wider by one bit",
        "nullspace",
        "fixed",
        r"least\(most\(x, low\), high\)",
        r"least(most(x, low), high + high * 0x1p-23)",
    ),
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
    Sabotage(
        "limits of the call are exchanged",
        "clip",
        "call",
        r"within\((.*), (l0), (h0)\)",
        r"within(\1, \3, \2)",
    ),
    Sabotage(
        "a neighbour's limits are taken", "clip", "call", r"(y0 = within\(.*), l0, h0\)", r"\1, l1, h1)"
    ),
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
    instead = re.sub(r"\b([kn])\b(?=\])", lambda size: str(getattr(of.vehicle, size[1])), sabotage.instead)
    source, count = re.subn(sabotage.pattern, instead, of.source, count=1)
    if not count or source == of.source:
        raise ValueError(f"{of.name}: nothing to break as in '{sabotage.name}'")
    return replace(of, files={**of.files, f"{of.name}.c": source})
