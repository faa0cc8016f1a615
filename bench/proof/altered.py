"""Changes that a preprocessor makes to C, compared with the C that is printed.

Compilers differ in it: an analyser that takes one branch of an #if says nothing of the others.
"""

import re
from itertools import zip_longest

from bench.proof.proof import Claim, not_shown
from bench.proof.subject import Subject, subject

_COMMENT_OR_TEXT = re.compile(
    r"""/\*.*?\*/|//[^\r\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'""", flags=re.DOTALL
)
_MEANT = re.compile(r"#|%:|\?\?|\\[ \t]+$|\b_[A-Z_]")
"""What means something to a preprocessor: directives, digraphs, trigraphs, a line that goes on for some, and
words that compilers reserve, such as _Pragma and macros of their own."""
_NESTED = re.compile(r"\s*#\s*(if|endif)")


def altered(of: Subject) -> str:
    """The first line of this that is another than the one that is printed, in words; empty if none is."""
    made = subject(of.vehicle, of.kernel, of.scalar, of.limits, of.faults).files
    for name in sorted({*made, *of.files}):
        for usual, found in zip_longest(chosen(made.get(name, "")), chosen(of.files.get(name, ""))):
            if usual != found:
                return f"{name}: '{found or ''}' is there for '{usual or ''}': compilers may differ in it"
    return ""


def of_all_branches(claims: list[Claim], of: Subject) -> list[Claim]:
    """Claims that one branch shows: not shown where the others are none that are printed."""
    words = altered(of)
    return [not_shown(each.claim, [words]) if words and each.verdict == "shown" else each for each in claims]


def chosen(text: str) -> list[str]:
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
