"""T f of an answer is the wrench that is promised, by what the C compares: shown, and each fault found."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product
from typing import get_args

import numpy as np
import pytest

from alloc import NotApplicable, Vehicle, list_vehicles, load_vehicle
from alloc.c.compiled import compiler
from alloc.kernels.tolerance import WRENCH_ERROR
from alloc.kernels.walk import EDGE
from alloc.program import Faults, Program, Scalar, Where, evaluate
from bench.demands.corners import attainable
from bench.proof import subject
from bench.proof.equation import EQUATION, OVERFLOW, WIDER, equation_claims, program_claims
from bench.proof.forms import UNIT
from bench.proof.symbolic import programs
from tests.not_asked import not_asked

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
RULES = ("clip", "redistribute", "group-scaling", "shrink")
METHODS = ("nullspace", "scaled", "scaled-by-group", "priority", *RULES, "pinv", "walsh")
FORMS = tuple(product(get_args(Scalar), get_args(Where), get_args(Faults)))
COUPLED = ("supply-vessel", "tiburon")
"""Vehicles with null spaces of two and more dimensions that are no separate ones."""


def is_open(vehicle: Vehicle, method: str, limits: Where, faults: Faults) -> bool:
    """True where it is known that the equation is not shown: docs/proof.md has the reasons."""
    if method == "priority" and vehicle.name == "bluerov2":
        return faults != "none"
    if method == "shrink" and limits == "fixed" and faults == "all":  # a direction that one program loses
        return any(vehicle.with_fault(i).rank < vehicle.rank for i in vehicle.working.tolist())
    levels = faults == "all" and method in ("scaled", "scaled-by-group", "priority")
    return vehicle.name in COUPLED and (method == "nullspace" or levels)


def asked() -> Iterator[object]:
    """Every method, vehicle and form of C; in a short run each method and vehicle in one form."""
    for at, (name, method) in enumerate(product(list_vehicles(), METHODS)):
        for form, (scalar, limits, faults) in enumerate(FORMS):
            marks = () if form == at % len(FORMS) else (pytest.mark.long,)
            yield pytest.param(name, method, scalar, limits, faults, marks=marks)


@pytest.mark.parametrize(("name", "method", "scalar", "limits", "faults"), list(asked()))
def test_every_answer_makes_its_wrench(
    name: str, method: str, scalar: Scalar, limits: Where, faults: Faults
) -> None:
    try:
        of = subject(load_vehicle(name), method, scalar, limits, faults)
    except NotApplicable as refusal:
        not_asked(str(refusal))
    claims, rows = equation_claims(of)
    verdicts = {claim.claim: claim.verdict for claim in claims}
    unknown = is_open(of.vehicle, method, limits, faults)
    wanted = {EQUATION: "not shown" if unknown else "shown"}
    if method in RULES:
        wanted[OVERFLOW] = "shown" if (method, limits) != ("shrink", "fixed") else "not shown"
    assert verdicts == wanted, claims
    assert unknown or [row.fault for row in rows] == [*programs(of)]


def with_nodes(program: Program, *operations: tuple[object, ...]) -> tuple[Program, int]:
    """The program with further operations, and the node of the first of them."""
    return replace(program, nodes=(*program.nodes, *operations)), len(program.nodes)


def with_node(program: Program, node: int, *operation: object) -> Program:
    return replace(program, nodes=(*program.nodes[:node], operation, *program.nodes[node + 1 :]))


def kinds(program: Program, kind: str) -> list[int]:
    return [node for node, operation in enumerate(program.nodes) if operation[0] == kind]


def always_solved(program: Program) -> Program:
    more, at = with_nodes(program, ("const", 0.0))
    return replace(more, status=at)


def decides(program: Program) -> int:
    """The comparison of what is missed, or of how far limits are crossed, with what that may be."""
    (node,) = (
        node
        for kind, most in (("le", 2.0), ("gt", 1.0))
        for node in kinds(program, kind)
        if (bound := program.nodes[program.nodes[node][2]])[0] == "const" and 0.0 < bound[1] < most
    )
    return node


def never_drawn_in(program: Program) -> Program:
    """Thrusts beyond limits are cut, whatever that costs."""
    node = decides(program)
    return with_node(program, node, "gt", *(program.nodes[node][2],) * 2)


def ten_times_as_much(program: Program) -> Program:
    node = decides(program)
    kind, a, bound = program.nodes[node]
    more, at = with_nodes(program, ("const", 10.0 * program.nodes[bound][1]))
    return with_node(more, node, kind, a, at)


def largest_for_sum(program: Program) -> Program:
    """The largest miss is compared, as it once was: it drops NaN."""
    sizes = {*kinds(program, "abs")}
    sums = [node for node in kinds(program, "add") if sizes & {*program.nodes[node][1:]}]
    for node in sums:
        program = with_node(program, node, "max", *program.nodes[node][1:])
    return program


def one_row_less(program: Program) -> Program:
    """The first axis is not looked at."""
    first = next(node for node in kinds(program, "add") if program.nodes[program.nodes[node][1]][0] == "abs")
    more, at = with_nodes(program, ("const", 0.0))
    return with_node(more, first, "add", at, program.nodes[first][2])


def not_cut(program: Program) -> Program:
    """The first thrust leaves as it was before limits."""
    end = program.outputs["f", 0]
    inner = program.nodes[program.nodes[end][1]][1]
    return replace(program, outputs={**program.outputs, ("f", 0): inner})


def half_of_a_thrust(program: Program) -> Program:
    """Half of the first thrust leaves."""
    end = program.outputs["f", 0]
    half, at = with_nodes(program, ("const", 0.5), ("mul", len(program.nodes), end))
    return replace(half, outputs={**half.outputs, ("f", 0): at + 1})


def another_factor(program: Program) -> Program:
    """A thousandth more of the first factor above zero that a product of tau has."""
    factors = [
        each
        for node in kinds(program, "mul")
        for each in program.nodes[node][1:]
        if program.nodes[each][0] == "const"
        and any(program.nodes[other][0] == "input" for other in program.nodes[node][1:])
    ]
    at = factors[0]
    return with_node(program, at, "const", 1.001 * program.nodes[at][1])


def half_of_the_share(program: Program) -> Program:
    share = program.outputs["share", 0]
    more, at = with_nodes(program, ("const", 0.5), ("mul", len(program.nodes), share))
    return replace(more, outputs={**more.outputs, ("share", 0): at + 1})


def other_way_round(program: Program) -> Program:
    kind, condition, a, b = program.nodes[program.status]
    return with_node(program, program.status, kind, condition, b, a)


COMPARED = (ten_times_as_much, one_row_less)
"""Faults of what compares T f with tau."""
MOVED = (ten_times_as_much, not_cut)
"""Faults of what compares thrusts with limits."""


@pytest.mark.parametrize(
    ("method", "change"),
    [
        *product(RULES[:3], (*COMPARED, half_of_a_thrust)),
        *product(RULES[:2], (another_factor,)),  # group-scaling holds T f to tau, however f was made
        *product(RULES, (always_solved, other_way_round)),
        *product(("nullspace", "scaled", "priority"), (*MOVED, another_factor, half_of_a_thrust)),
        *product(("scaled", "priority"), (always_solved, half_of_the_share, never_drawn_in)),
        ("shrink", not_cut),
        ("pinv", another_factor),
    ],
)
def test_what_breaks_the_equation_is_not_shown(method: str, change: Callable[[Program], Program]) -> None:
    of = subject(load_vehicle("ukwial"), method, "double", "fixed")
    made = programs(of)
    assert program_claims(made, of)[0][0].verdict == "shown"
    claims, _ = program_claims({**made, -1: change(made[-1])}, of)
    assert claims[0].verdict == "not shown"
    assert all("fault -1" in word for word in claims[0].words)


@pytest.mark.parametrize("method", RULES[:3])
@pytest.mark.parametrize("limits", ["fixed", "call"])
def test_a_maximum_that_drops_nan_is_not_shown_where_operations_overflow(method: str, limits: Where) -> None:
    of = subject(load_vehicle("ukwial"), method, "float", limits)
    made = programs(of)
    claims, _ = program_claims({**made, -1: largest_for_sum(made[-1])}, of)
    assert {claim.claim: claim.verdict for claim in claims} == {EQUATION: "shown", OVERFLOW: "not shown"}


@pytest.mark.parametrize("method", ["clip", "nullspace", "scaled", "pinv"])
@pytest.mark.parametrize("scalar", get_args(Scalar))
def test_no_answer_misses_more_than_is_shown(method: str, scalar: Scalar) -> None:
    """Demands inside, on the edge and of all sizes; their wrench in more digits than the C has."""
    of = subject(load_vehicle("bluerov2-heavy"), method, scalar, "fixed")
    row, program, vehicle = equation_claims(of)[1][0], programs(of)[-1], of.vehicle
    rng = np.random.default_rng(53)
    taus = attainable(vehicle, rng, 4000).T * rng.choice([0.5, 1.0, 1.0 + 1e-7, 10.0, 1e9], (4000, 1))
    taus = taus.astype(np.float32 if scalar == "float" else np.float64).astype(float)
    got = evaluate(replace(program, scalar=scalar), taus)
    share = got.share[:, 0] if got.share.size else np.ones(len(taus))
    answered = (got.status == 0) | ((got.status == 1) & bool(got.share.size))
    made = got.F.astype(np.longdouble) @ vehicle.TP.T.astype(np.longdouble)
    missed = np.abs(made - share[:, None] * taus.astype(np.longdouble))
    may = row.promise * WRENCH_ERROR[scalar] * vehicle.wrench_scale
    rounded = row.roundings * UNIT[scalar] * (np.abs(got.F) @ np.abs(vehicle.TP).T).max(axis=0)
    of_shares = WIDER * EDGE[scalar] * np.abs(share[:, None] * taus) if got.share.size else 0.0
    assert answered.sum() > 500
    assert (missed <= may + rounded + of_shares)[answered].all()


def test_what_no_comparison_bounds_has_its_reason() -> None:
    of = subject(load_vehicle("ukwial"), "nullspace", "double", "fixed")
    made = programs(of)
    for change, reason in ((not_cut, "is not shown to be moved"), (early, "returned early")):
        claims, _ = program_claims({-1: change(made[-1])}, of)
        assert reason in claims[0].words[0]


def early(program: Program) -> Program:
    return replace(program, exits=((program.exits[0][0], 0), *program.exits))
