"""The C is read back and is the program that it was printed from; C that is anything else is told."""

import re
from dataclasses import replace

import pytest

from alloc import load_vehicle
from alloc.c import Target
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


def test_limits_of_zero_for_the_thruster_that_is_off_are_asked_as_the_c_asks() -> None:
    """Its zeros are numbers, too, and C that has no table for faults looks at them as at any other."""
    claim = translated(subject(load_vehicle("bluerov2"), "nullspace", "float", "call", "all"))
    assert claim.verdict == "shown", claim.words


BROKEN = [each for each in SABOTAGES if not any(word in each.name for word in NO_OPERATION)]


@pytest.mark.parametrize("sabotage", BROKEN, ids=lambda each: each.name)
def test_c_that_was_changed_is_not_the_program(sabotage: Sabotage) -> None:
    whole = subject(load_vehicle("ukwial"), sabotage.kernel, "double", sabotage.limits)
    assert translated(whole).verdict == "shown"
    claim = translated(sabotaged(whole, sabotage))
    assert claim.verdict == "not shown"
    assert claim.words


@pytest.mark.parametrize(
    "sabotage", [each for each in SABOTAGES if each not in BROKEN], ids=lambda each: each.name
)
def test_what_is_no_operation_is_there_to_be_broken(sabotage: Sabotage) -> None:
    """C that changes leaves a pattern without a match: nothing was broken then, and nothing looked at."""
    whole = subject(load_vehicle("ukwial"), sabotage.kernel, "double", sabotage.limits)
    assert sabotaged(whole, sabotage).source != whole.source


TEXTS = {
    "a loop that ends one early": ("i < n; i++) {", "i + 1 < n; i++) {"),
    "a loop that leaves every other one out": ("i < n; i++) {", "i < n; i += 2) {"),
    "a loop that writes its counter": ("good &= x[i] - x[i] == 0.0;", "good &= x[i] - x[i] == 0.0; i = n;"),
    "a sum in single precision": ("const double x0 = ", "const float x0 = "),
    "a sum cut to a whole number": ("const double x0 = ", "const int x0 = "),
    "a parameter in single precision": ("tb_within(double x,", "tb_within(float x,"),
    "a result in single precision": ("double tb_within(", "float tb_within("),
    "a number that is cast": ("= tau[0];", "= (float)tau[0];"),
    "a thrust that is written inside of a cast": (
        "    return TB_SOLVED;",
        "    (void)(t0 > 123.0 && ((f[0] = 0.0) > 1.0));\n    return TB_SOLVED;",
    ),
    "an entry of an array that nobody read": (
        "    return TB_SOLVED;",
        "    more[0] = 1;\n    return TB_SOLVED;",
    ),
    "a table in single precision": ("static const double c[]", "static const float c[]"),
}


@pytest.mark.parametrize("change", TEXTS)
def test_what_c_says_beside_operations_is_read_too(change: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Types round, and loops may end early: read without them, this was the program.

    That the text of helpers is another one is not asked here, so that they are read.
    """
    monkeypatch.setattr("bench.proof.source.preprocessor_change", lambda _: "")
    whole = subject(load_vehicle("ukwial"), "nullspace", "double", "fixed")
    before, after = TEXTS[change]
    assert before in whole.source
    changed = replace(whole, files={**whole.files, f"{whole.name}.c": whole.source.replace(before, after)})
    assert translated(changed).verdict == "not shown"


@pytest.mark.parametrize(
    ("before", "after"), [(r"low\[i\] - \S+ ", "low[i] - 6e-3 "), (r"turn < \d+", "turn < 1")]
)
def test_a_loop_over_data_is_the_one_that_is_printed(before: str, after: str) -> None:
    """Its constants and turns are no operations of the program: nothing read them."""
    whole = subject(load_vehicle("bluerov2-heavy"), "redistribute", "double", "fixed")
    other = re.sub(before, after, whole.source)
    assert other != whole.source
    claim = translated(replace(whole, files={**whole.files, f"{whole.name}.c": other}))
    assert claim.words == ["the loop cascade: its text is another one"]


def test_a_name_that_hides_another_is_another_number() -> None:
    """A declaration inside a branch ends with it: read as an assignment, this was the program."""
    whole = subject(load_vehicle("ukwial"), "scaled", "double", "fixed")
    hidden = re.sub(r"^( +)(in0 = .*)$", r"\1const double \2\n\1(void)in0;", whole.source, flags=re.MULTILINE)
    assert hidden != whole.source
    claim = translated(replace(whole, files={**whole.files, f"{whole.name}.c": hidden}))
    assert claim.words == ["in0 is declared where it is known already"]


def test_each_single_node_that_is_changed_is_told() -> None:
    """A sign, a constant by one bit, a minimum for a maximum, a comparison: in whatever place."""
    program = Target(vehicle=load_vehicle("ukwial"), method=recipe("nullspace")).programs[-1]
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
