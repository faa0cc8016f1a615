"""C that breaks no claim on memory or limits, and still answers wrongly, is not shown."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.c import printed
from alloc.c.compiled import compiler
from alloc.program import Program, Scalar, Where, evaluate
from bench.proof import Proof, Subject, answers, subject
from bench.proof.equation import EQUATION, MIXED, STRONG, equation_claims, program_claims
from bench.proof.proof import Claim
from bench.proof.safety.claims import _stateless
from bench.proof.symbolic import programs as read_back
from sabotages import SABOTAGES, sabotaged
from tests.places import DOCS

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
UKWIAL = load_vehicle("ukwial")


def changed(kernel: str, change: Callable[[Program], Program], limits: Where = "fixed") -> Subject:
    """The C of a kernel whose program is another one for the whole vehicle."""
    of = subject(UKWIAL, kernel, "double", limits)
    made = of.target.programs
    files = printed(of.target, {**made, -1: change(made[-1])})
    return replace(of, files=files)


def with_node(program: Program, node: int, *operation: object) -> Program:
    return replace(program, nodes=(*program.nodes[:node], operation, *program.nodes[node + 1 :]))


def broken(name: str) -> Subject:
    """The C of the sabotage of that name."""
    (sabotage,) = (each for each in SABOTAGES if each.name == name)
    return sabotaged(subject(UKWIAL, sabotage.kernel, "double", sabotage.limits), sabotage)


def not_least(program: Program) -> Program:
    """The null space's coordinate nearest to a limit's size, where it should be nearest to zero."""
    zero = program.nodes.index(("const", 0.0))
    other = next(i for i, node in enumerate(program.nodes) if node[0] == "const" and node[1] > 1.0)
    at = next(i for i, (kind, *rest) in enumerate(program.nodes) if kind in ("min", "max") and zero in rest)
    kind, *rest = program.nodes[at]
    return with_node(program, at, kind, *(other if each == zero else each for each in rest))


def half(program: Program) -> Program:
    less = len(program.nodes)
    nodes = (*program.nodes, ("const", 0.5), ("mul", program.outputs["share", 0], less))
    return replace(program, nodes=nodes, outputs={**program.outputs, ("share", 0): less + 1})


def half_where_one_never_stops(program: Program) -> Program:
    """Half the share where the first thruster must push, which the vehicle's own limits never say."""
    whole, less = program.outputs["share", 0], half(program)
    first, low = len(less.nodes), less.nodes.index(("input", "f_min", 0))
    nodes = (("const", 0.0), ("lt", first, low), ("choose", first + 1, less.outputs["share", 0], whole))
    return replace(less, nodes=less.nodes + nodes, outputs={**less.outputs, ("share", 0): first + 2})


def nothing_of_a_part(program: Program) -> Program:
    """No thrust where less than all of a demand is delivered, and the shares as before."""
    first = len(program.nodes)
    thrusts = {place: node for place, node in program.outputs.items() if place[0] == "f"}
    cut = [("choose", first + 2, first + 1, node) for node in thrusts.values()]
    nodes = (("const", 1.0), ("const", 0.0), ("lt", program.outputs["share", 0], first), *cut)
    outputs = {place: first + 3 + i for i, place in enumerate(thrusts)}
    return replace(program, nodes=program.nodes + nodes, outputs={**program.outputs, **outputs})


def thousandth_less() -> Subject:
    """The C of redistribute with an entry of a table that its loop reads a thousandth smaller."""
    of = subject(UKWIAL, "redistribute", "double", "fixed")
    table = re.search(r"redistribute_E\[4\]\[3\] = \{\{(\S+),", of.source)
    assert table
    source = of.source.replace(table[0], table[0].replace(table[1], repr(0.999 * float(table[1]))))
    return replace(of, files={**of.files, f"{of.name}.c": source})


def largest_for_least_on_some_processors() -> Subject:
    of = subject(UKWIAL, "nullspace", "double", "fixed")
    text = of.source.replace("__builtin_fmin(a, b)", "__builtin_fmax(a, b)")
    assert text != of.source
    return replace(of, files={**of.files, f"{of.name}.c": text})


def red(of: Subject) -> list[str]:
    return [claim.claim for claim in answers.answer_claims(of) if claim.verdict != "tested"]


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize(
    ("name", "kernel", "scalar"),
    [
        ("ukwial", "nullspace", "float"),
        ("bluerov2", "scaled", "float"),  # with a thruster off it spans fewer directions
        ("bluerov2", "priority", "double"),
        ("bluerov2-heavy", "scaled-by-group", "float"),  # in floats a share led out of the set
        ("ukwial", "redistribute", "double"),
        ("ukwial", "clip", "float"),
        ("ukwial", "group-scaling", "float"),
        ("ukwial", "pinv", "double"),
    ],
)
def test_answers_are_met_refused_and_least_as_the_method_says(
    name: str, kernel: str, scalar: str, limits: str
) -> None:
    of = subject(load_vehicle(name), kernel, scalar, limits)  # type: ignore[arg-type]  # pytest's are text
    assert red(of) == []


def test_c_that_knows_no_faults_is_asked_none() -> None:
    assert red(subject(UKWIAL, "nullspace", "double", "fixed", "none")) == []


@pytest.mark.parametrize(
    ("of", "claim"),
    [
        (broken("all is refused"), answers.SOLVED.format(which=answers.ATTAINABLE)),
        (broken("far too much is called solved"), answers.MADE),
        (changed("nullspace", not_least), answers.EFFORT),
        (changed("scaled", half), answers.SHARES),
        (changed("scaled", half_where_one_never_stops, "call"), answers.DELIVERED),
        (changed("scaled", nothing_of_a_part), answers.DELIVERED),
        (changed("priority", not_least), answers.DELIVERED),
        (thousandth_less(), answers.TWIN),
        (largest_for_least_on_some_processors(), answers.SAME),
    ],
    ids=[
        "refuses all",
        "a slack a million times as large",
        "more effort than needed",
        "half a share",
        "half a share within limits that only a call has",
        "shares without thrusts",
        "more effort than a part needs",
        "another number in a table that a loop reads",
        "another instruction where the FPU has one",
    ],
)
def test_c_that_is_safe_and_wrong_is_told(of: Subject, claim: str) -> None:
    assert claim in red(of)


@pytest.mark.parametrize(
    "kept",
    [
        "static int calls;",
        "static double last[2];",
        "static const double *at;",
        "static double *const behind = 0;",
        "static const struct { double *at; } held = {0};",
    ],
    ids=lambda each: each,
)
def test_data_that_outlive_a_call_are_no_part_of_safe_c(kept: str) -> None:
    of = subject(UKWIAL, "nullspace", "double", "fixed")
    assert _stateless(of).verdict == "shown"
    source = of.source.replace("    switch (fault) {", f"    {kept}\n    switch (fault) {{")
    within = _stateless(replace(of, files={**of.files, f"{of.name}.c": source}))
    outside = _stateless(replace(of, files={**of.files, f"{of.name}.c": of.source + kept + "\n"}))
    assert (within.verdict, outside.verdict) == ("not shown", "not shown")


def in_part(times: float) -> Vehicle:
    """A surveyed vehicle whose pitch has ``times`` what is weak."""
    vehicle = load_vehicle(DOCS / "vehicles/bluerov2-surveyed.yaml")
    sigma = vehicle.directions.sigma
    return replace(vehicle, weak_limit=float(sigma[-1] / sigma[0]) / times)


@pytest.mark.parametrize("kernel", ["scaled", "priority"])
def test_of_a_weak_direction_nothing_is_claimed_and_the_rest_is_shown(kernel: str) -> None:
    of = subject(in_part(0.9), kernel, "double", "fixed", "none")
    claims = answers.answer_claims(of, 200)
    assert [claim.claim for claim in claims if claim.verdict == "not shown"] == []
    assert answers.MADE + answers.STRONG in [claim.claim for claim in claims]
    (equation,), (miss,) = equation_claims(of)
    assert (equation.claim, equation.verdict) == (EQUATION + STRONG, "shown")
    assert miss.of_tau < 1e3  # it was 1e16 roundings: all of the weak part


def test_mixed_answers_are_held_to_python_s_and_to_no_wrench() -> None:
    of = subject(in_part(1.4), "scaled", "double", "fixed", "none")
    claims = {claim.claim: claim.verdict for claim in answers.answer_claims(of, 200)}
    assert claims[answers.MIX] == "tested"
    assert not {answers.MADE, answers.SHARES, answers.DELIVERED} & claims.keys()
    (made,) = of.target.programs.values()
    less = replace(of, files=printed(of.target, {-1: with_another_share_of_the_mix(made)}))
    assert answers.MIX in red(less)


@pytest.mark.parametrize("kernel", ["scaled", "priority", "scaled-by-group"])
@pytest.mark.parametrize(("scalar", "limits"), [("double", "fixed"), ("float", "call")])
def test_each_of_the_answers_that_are_mixed_makes_its_wrench(
    kernel: str, scalar: Scalar, limits: Where
) -> None:
    of = subject(in_part(1.4), kernel, scalar, limits, "none")
    ((claim,), (_,)) = equation_claims(of)
    assert (claim.claim, claim.verdict) == (EQUATION + MIXED, "shown")
    (made,) = of.target.programs.values()
    for change in (with_another_share_of_the_mix, with_the_answers_exchanged, with_another_second_answer):
        ((claim,), _) = program_claims({-1: change(made)}, of)
        assert claim.verdict == "not shown", change


def mix_of(program: Program) -> int:
    """The difference of answers of which the first thrust has w."""
    (moved,) = program.nodes[program.nodes[program.nodes[program.outputs["f", 0]][1]][1]][2:]
    return max(program.nodes[moved][1:], key=lambda each: program.nodes[each][0] == "sub")


def with_the_answers_exchanged(program: Program) -> Program:
    node = mix_of(program)
    return with_node(program, node, "sub", *program.nodes[node][:0:-1])


def with_another_second_answer(program: Program) -> Program:
    """A thousandth more of the first thrust of the second answer, before it is moved onto limits."""
    node = mix_of(program)
    at = program.nodes[node][1]
    more = replace(program, nodes=(*program.nodes, ("const", 1.001), ("mul", len(program.nodes), at)))
    exchanged: Program = with_node(more, node, "sub", len(program.nodes) + 1, program.nodes[node][2])
    return exchanged


def with_another_share_of_the_mix(program: Program) -> Program:
    """Half the w with which the first thrusts of two are mixed."""
    (w,) = (node[1] for node in program.nodes if node[0] == "const" and node[1] == pytest.approx(0.4))
    return with_node(program, program.nodes.index(("const", w)), "const", w / 2)


def test_a_claim_that_nothing_bears_on_is_not_shown() -> None:
    assert answers._claim("of nothing", {}, lambda _: (1, "")).verdict == "not shown"


def test_a_proof_s_first_line_is_the_least_of_its_claims() -> None:
    facts = dict.fromkeys(("vehicle", "method", "scalar", "limits", "function", "sha256", "thrustbench"), "-")
    shown, tested, lacking = (
        Claim(claim="a", verdict=verdict, by="")  # type: ignore[arg-type]  # texts of the Literal
        for verdict in ("shown", "tested", "not shown")
    )

    def least(*claims: Claim, numbers: list[Claim]) -> str:
        made = Proof(**facts, files=[], tools={}, assumptions=[], claims=list(claims), numbers=numbers)
        return made.least

    assert least(shown, numbers=[shown]) == "all shown"
    assert least(shown, tested, numbers=[]) == "all shown, but for 1 that are tested"
    assert least(shown, tested, numbers=[lacking]) == "1 of 3 claims not shown"


@pytest.mark.parametrize(
    ("name", "kernel", "scalar", "tau"),
    [
        (
            *("bluerov2-heavy", "clip", "float"),
            (0.0, 0.0, 5.249683651848541e37, 1.8445835994360808e38, -1.0098510755079352e38, 0.0),
        ),
        pytest.param(
            *("ukwial", "scaled", "double"),
            (1.4501914567989153e308, 1.3389381806628896e308, -1.7394729420972155e308),
            marks=pytest.mark.xfail(strict=True, reason="docs/proof.md, Numbers: products with tau overflow"),
        ),
    ],
)
def test_a_demand_next_to_the_largest_number_is_answered_with_the_wrench_that_is_promised(
    name: str, kernel: str, scalar: Scalar, tau: tuple[float, ...]
) -> None:
    """Sums that tell whether arguments are numbers stay finite there, and a maximum drops NaN."""
    vehicle = load_vehicle(name)
    program = read_back(subject(vehicle, kernel, scalar, "fixed"))[-1]
    got = evaluate(replace(program, scalar=scalar), np.array([tau]))
    wrench = got.share[0].prod() * np.array(tau)
    kept = np.abs(vehicle.TP @ got.F[0] - wrench) <= 1e-3 * vehicle.wrench_scale
    promises = (0, 1) if got.share.size else (0,)  # a rule's part of tau is any
    assert got.status[0] not in promises or kept.all()
