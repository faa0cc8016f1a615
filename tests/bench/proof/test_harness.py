"""C for the analyser: numbers that it may take for finite are volatile or asserted, or it is refused."""

import pytest

from alloc.c.compiled import compiler
from bench.proof.safety.harness import any_bits
from bench.proof.source import NotRead

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
AROUND = """\
struct ends {{ double low, high; int n; }};
static const double table[2] = {{1.0, 2.0}};
static void keep(double x[2], const double *at) {{ x[0] = at[0]; }}
int call(const double tau[2], double f[2], struct ends *to)
{{
    struct ends ends = {{0}};
    double known[2] = {{1.0, 2.0}};
    double own[2];
    {statement}
    return 0;
}}
"""


def rewritten(statement: str) -> list[str]:
    """Lines of the function around a statement as the analyser reads them."""
    text = any_bits({"own.c": AROUND.format(statement=statement)}, "own.c", ("known",))
    return [line.strip() for line in text[text.index("int call(") :].splitlines()]


@pytest.mark.parametrize(
    ("statement", "asserted"),
    [
        ("ends.low = tau[0];", ["ends.low"]),
        ("ends.low += tau[0];", ["ends.low"]),
        ("ends\n  .high\n  = tau[0];", ["ends.high"]),
        ("to->low = tau[0]; to->high = tau[1];", ["to->low", "to->high"]),
        ("(*to).low = tau[0];", ["(*to).low"]),
        ("struct ends more = {tau[0],\n  tau[1],\n  3};", ["more.low", "more.high"]),
        ("if (tau[0] > 0.0) { known[1] = tau[1]; }", ["known[1]"]),
        (
            "switch (to->n) { case 1: known[0] = tau[1]; break; default: ends.low = 1.0; }",
            ["known[0]", "ends.low"],
        ),
        ("to->n = 3;", []),
    ],
)
def test_what_writes_a_number_that_keeps_its_value_stands_before_its_assertion(
    statement: str, asserted: list[str]
) -> None:
    found = [
        line.partition("is_finite(")[2][: -len("); */")] for line in rewritten(statement) if "/*@" in line
    ]
    begun = ["ends.low", "ends.high", "known[0]", "known[1]"]
    assert found == [*begun, *asserted]


@pytest.mark.parametrize(
    "statement",
    [
        "if (tau[0] > 0.0) ends.low = tau[1];",
        "f[0] = ends.low = tau[1];",
        "for (ends.low = 0.0; ends.low < tau[0]; ends.low++) { }",
        "*to = ends;",
        "ends = *to;",
        "double *at = &ends.low;",
        "double *at = known;",
        "const double *at = tau + 1;",
        "*(&known[0]) = tau[0];",
        "keep(known, table);",
        "*(double *)f = tau[0];",
        "*(f + 1) = tau[0];",
        "memcpy(&ends, tau, sizeof ends);",
        "typedef double real; real more[2]; f[0] = more[0];",
        "union { double low; int n; } two; two.low = tau[0];",
        "*to = (struct ends){tau[0], tau[1], 3};",
        "struct two { struct ends ends; } two = {{tau[0], 1.0, 3}};",
        "struct ends two[2] = {{tau[0], 1.0, 3}};",
    ],
)
def test_other_ways_to_write_or_point_at_a_number_are_refused(statement: str) -> None:
    """A regular expression would leave each as it is, and the analyser take the number for finite."""
    with pytest.raises(NotRead):
        rewritten(statement)


@pytest.mark.parametrize(
    ("statement", "line"),
    [
        ("f[0] = own[1];", "volatile double own[2];"),
        ("own[0] = tau[0];", "double own[2];"),
        ("own[0] += tau[0];", "volatile double own[2];"),
        ("keep(own, tau);", "double own[2];"),
    ],
)
def test_arrays_that_are_read_are_volatile(statement: str, line: str) -> None:
    lines = rewritten(statement)
    assert line in lines
    assert lines[0].startswith("int call(const volatile double tau[2], double f[2]")


def test_a_parameter_is_volatile_where_a_call_points_it_at_an_array() -> None:
    """One that points at tables alone keeps their values."""
    for argument, volatile in (("tau", "volatile "), ("table", "")):
        text = any_bits({"own.c": AROUND.format(statement=f"keep(f, {argument});")}, "own.c", ())
        assert f"void keep(double x[2], const {volatile}double *at)" in text
