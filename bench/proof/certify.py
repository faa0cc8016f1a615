"""One kernel, everything that can be shown of it."""

import re
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType

from alloc.c import digest
from alloc.files.textfile import write_folder
from bench.harness import machine
from bench.proof import tools
from bench.proof.answers import DEMANDS, answer_claims
from bench.proof.equation import equation_claims
from bench.proof.proof import ASSUMPTIONS, Broken, Proof, unproved
from bench.proof.safety import claims as safety
from bench.proof.safety import esc
from bench.proof.source import Subject
from bench.proof.translation import translated
from bench.proof.worst import Counted, worst_paths

USUAL, THOROUGH = DEMANDS, 10 * DEMANDS
"""Demands of each fault."""
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
"""Reasons why generated C breaks a rule, in words of its own: the rules' texts are MISRA's."""


def prove(
    of: Subject,
    demands: int = USUAL,
    say: Callable[[str], None] = lambda _: None,
    before: Counted = MappingProxyType({}),
) -> Proof:
    """The proof of a kernel; raises NotInstalled where Frama-C is missing.

    ``say`` is told what is looked at next; ``before`` are costly demands that are known.
    """
    begin = time.perf_counter()
    say("memory, status and limits")
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        claims, way = safety.claims(of, Path(folder)), esc.claims(of, Path(folder))
        rules = broken_rules(of, Path(folder))
        runs = claims[0].verdict == "shown"  # C that may write anywhere is not run
        if runs and way and way[0].verdict == "shown":
            way += esc.esc_tests(of, Path(folder))
    claims += [*way, translated(of)]
    if runs:
        say("answers to many demands")
        claims += answer_claims(of, demands)
    say("the equation of an answer")
    equation, misses = equation_claims(of)
    say("worst paths")
    paths, refuted, lacking = worst_paths(of, before)
    beside = esc.files(of)
    if rules is None:
        lacking.append(unproved("MISRA C:2012", ["needs cppcheck: " + tools.remedy(["cppcheck"])]))
    return Proof(
        vehicle=of.vehicle.name,
        method=of.kernel,
        scalar=of.scalar,
        limits=of.limits,
        function=of.name,
        files=[f"{of.name}.h", f"{of.name}.c"],
        sha256=digest(of.name, of.files),
        esc_files=[*beside],
        esc_sha256=sha256("".join(beside.values()).encode()).hexdigest() if beside else "",
        thrustbench=machine.commit(),
        tools={name: tools.version(name) for name in tools.PACKAGES},
        assumptions=ASSUMPTIONS,
        claims=[*claims, *refuted],
        numbers=[*equation, *lacking],
        misses=misses,
        worst_paths=paths,
        misra=rules or [],
        seconds=round(time.perf_counter() - begin, 1),
    )


def broken_rules(of: Subject, folder: Path) -> list[Broken] | None:
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
