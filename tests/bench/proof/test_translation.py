"""The C is read back and is the program that it was printed from; C that is anything else is told."""

import re
from dataclasses import replace

import pytest

from alloc import load_vehicle
from alloc.c import programs as made
from alloc.c.compiled import compiler
from alloc.methods import recipe
from alloc.program import Where
from bench.proof import subject
from bench.proof.translation import difference, translated
from sabotages import SABOTAGES, Sabotage, sabotaged

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
ONE_BIT = 2.0**-52
NO_OPERATION = (
    "constant behind the table",
    "integer overflows",
    "row",
    "stack held",
    "touched by a call",
    "outlives",
)
"""Breaks of what is C and no operation: tables, loops over data, a write that another one follows."""


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize(
    ("name", "kernel"),
    [
        ("ukwial", "nullspace"),
        ("supply-vessel", "nullspace"),
        ("bluerov2-heavy", "priority"),
        ("ukwial", "shrink"),
        ("ukwial", "redistribute"),
        ("ukwial", "pinv"),
    ],
)
def test_the_c_is_the_program_node_by_node(name: str, kernel: str, limits: Where) -> None:
    """Steps with branches, levels, straight code, a loop over data, and a closed form."""
    claim = translated(subject(load_vehicle(name), kernel, "float", limits))
    assert claim.verdict == "shown", claim.words


@pytest.mark.parametrize(
    ("kernel", "limits"),
    [("scaled", "fixed"), ("scaled", "call"), ("redistribute", "call"), ("pinv", "fixed")],
)
def test_a_function_for_all_faults_is_the_program_of_each(kernel: str, limits: Where) -> None:
    of = subject(load_vehicle("bluerov2"), kernel, "float", limits, "all")
    claim = translated(of)
    assert claim.verdict == "shown", claim.words
    row = re.search(r"_of\[7\]\[\d+\] = \{\n(.*)\n    \{([^,]*)", of.source)
    assert row
    wrong = of.source.replace(row[0], row[0][: -len(row[2])] + "0.125F")
    claim = translated(replace(of, files={**of.files, f"{of.name}.c": wrong}))
    assert [word[:7] for word in claim.words] == ["fault 0"]


BROKEN = [each for each in SABOTAGES if not any(word in each.name for word in NO_OPERATION)]


@pytest.mark.parametrize("sabotage", BROKEN, ids=lambda each: each.name)
def test_c_that_was_changed_is_not_the_program(sabotage: Sabotage) -> None:
    whole = subject(load_vehicle("ukwial"), sabotage.kernel, "double", sabotage.limits)
    assert translated(whole).verdict == "shown"
    claim = translated(sabotaged(whole, sabotage))
    assert claim.verdict == "not shown"
    assert claim.words


def test_each_single_node_that_is_changed_is_told() -> None:
    """A sign, a constant by one bit, a minimum for a maximum, a comparison: in whatever place."""
    (program,) = (
        each
        for fault, each in made(load_vehicle("ukwial"), recipe("nullspace"), "double").items()
        if fault < 0
    )
    others = {"add": "sub", "sub": "add", "min": "max", "max": "min", "le": "lt", "lt": "le"}
    changed = 0
    for at, (kind, *rest) in enumerate(program.nodes):
        other = (others[kind], *rest) if kind in others else None
        if kind == "const" and rest[0]:
            other = ("const", rest[0] * (1 + ONE_BIT))
        if other is not None:
            nodes = (*program.nodes[:at], other, *program.nodes[at + 1 :])
            assert difference(program, replace(program, nodes=nodes)), (at, kind, rest)
            changed += 1
    assert changed > 30
