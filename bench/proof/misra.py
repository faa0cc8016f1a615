"""MISRA C:2012 by cppcheck's add-on: the rules that the C breaks, each with the reason why."""

import re
from collections import Counter
from pathlib import Path

from alloc.files.textfile import write_folder
from bench.proof import tools
from bench.proof.proof import Broken
from bench.proof.subject import Subject

REASONS = {
    "2.4": "Advisory. The enumeration of status values has no name, and needs none: its constants are used.",
    "8.9": "Advisory. Tables of the cascade stand in front of the two functions that share its numbers.",
    "9.3": "Required. {0} sets the first element, and C99 6.7.8 all others to zero, which is what is meant.",
    "10.3": "Required. An int holds what a comparison gives, 0 or 1: C90's and C99's own type of it.",
    "12.1": "Advisory. a + b * c needs no brackets for who reads formulas; generated sums are long.",
    "12.3": "Advisory. The comma stands between names that one declaration defines; it is no operator.",
    "14.4": "Required. The condition is a comparison, negated, or an int that holds one (see 10.3).",
    "15.5": "Advisory. A demand that is refused returns at once: one exit would cost every answer a branch.",
}
"""Why generated C breaks a rule, in words of its own: the rules' texts are MISRA's."""


def broken(of: Subject, folder: Path) -> list[Broken] | None:
    """The rules that header and source break; None where cppcheck is not there."""
    if "cppcheck" in tools.absent():
        return None
    write_folder(folder, of.files)
    command = [
        "cppcheck", "--addon=misra", "--enable=style", "--std=c99", "--quiet", "-D__GNUC__=12", "-U__ARM_FP",
        "--suppress=missingIncludeSystem", "--template={id} {file}:{line}", f"{of.name}.c",
    ]  # fmt: skip
    printed = tools.run(command, folder)
    rules = Counter(re.findall(r"^misra-c2012-(\d+\.\d+) ", printed, re.M))
    order = sorted(rules, key=lambda rule: [int(part) for part in rule.split(".")])
    return [Broken(rule=rule, places=rules[rule], reason=REASONS.get(rule, "")) for rule in order]
