"""A kernel as a value: equal nodes once, calculated for many demands as Python and C answer them."""

import numpy as np
import pytest

from alloc import NotApplicable, Status, build, load_vehicle
from alloc.methods import recipe, recipes
from alloc.program import Branch, Builder, clamp, evaluate, least, most, operands
from alloc.program.sums import product, shared_sums, signed
from bench.demands import build_demands

UKWIAL = load_vehicle("ukwial")
STRAIGHT = [name for name in recipes() if name not in ("redistribute", "soft")]


def test_equal_nodes_are_made_once_and_zeros_of_either_sign_are_two() -> None:
    builder = Builder(UKWIAL)
    a, b, _ = builder.tau
    assert a + b == a + b
    assert a + b != b + a  # rounding is the same, but C's order is the method's
    assert builder.graph.constant(0.0) != builder.graph.constant(-0.0)


def test_a_number_times_one_is_itself_and_known_numbers_are_python_s() -> None:
    builder = Builder(UKWIAL)
    a = builder.tau[0]
    assert 1.0 * a == a
    assert least(3.0, 2.0) == 2.0
    assert clamp(7.0, 1.0, 5.0) == 5.0


def test_constants_of_a_float_program_are_rounded_to_float() -> None:
    graph = Builder(UKWIAL, scalar="float").graph
    assert graph.nodes[graph.constant(0.1).node] == ("const", float(np.float32(0.1)))


def test_rows_that_share_a_sum_take_it_once_and_a_value_that_stands_twice_counts_twice() -> None:
    builder = Builder(UKWIAL)
    a, b, c = builder.tau
    rows = product(np.array([[1.0, 1, 1], [1, 1, -1], [0, 2, 0]]), [a, b, c]).rows
    made, short = shared_sums(rows)
    assert made == [a + b]
    assert signed(short[0]) == (a + b) + c or signed(short[0]) == c + (a + b)
    _, twice = shared_sums(product(np.array([[1.0, 1.0]]), [a, a]).rows)
    assert signed(twice[0]) == a + a


def test_what_nobody_needs_is_left_out_and_operands_stand_first() -> None:
    builder = Builder(UKWIAL)
    a, b, _ = builder.tau
    builder.compute((a * b).named("unused"))
    program = builder.program([a + b, a - b, 0.0, 0.0], Status.SOLVED)
    assert not [operation for operation in program.nodes if operation[0] == "mul"]
    for node, operation in enumerate(program.nodes):
        assert all(each < node for each in operands(operation))


def test_a_number_that_a_branch_shares_with_later_steps_is_calculated_before_it() -> None:
    builder = Builder(UKWIAL)
    a, b, c = builder.tau
    both = a * b
    with builder.where(a > 0.0) as merged:
        inside = merged(both + c, 0.0)
    program = builder.program([inside, both, 0.0, 0.0], Status.SOLVED)
    before = program.steps[: [isinstance(step, Branch) for step in program.steps].index(True)]
    assert ("mul",) in [program.nodes[step][:1] for step in before if isinstance(step, int)]
    (branch,) = (step for step in program.steps if isinstance(step, Branch))
    assert [program.nodes[step][0] for step in branch.steps if isinstance(step, int)] == ["input", "add"]
    assert not program.straight


def test_a_branch_that_comes_to_what_is_known_already_is_left_out() -> None:
    """C declared the variable of its result again, in the inner block, and took that for the outer one's."""
    builder = Builder(UKWIAL)
    a, b, c = builder.tau
    with builder.where(a > 0.0) as merged:
        x = merged(b + 1.0, b).named("x")
    with builder.where(b > 0.0) as outer:
        with builder.where(a > 0.0) as merged:
            assert merged(b + 1.0, b) == x
        with builder.where(c > 0.0) as merged:
            y = merged(c * b, x)
        z = outer(y, x)
    program = builder.program([z, x, 0.0, 0.0], Status.SOLVED)
    first, second = (step for step in program.steps if isinstance(step, Branch))
    assert len(first.merged) == 1
    inner = [step.merged for step in second.steps if isinstance(step, Branch)]
    assert len(inner) == 1
    assert not {*first.merged} & {*inner[0], *second.merged}


def test_exits_inside_a_branch_are_taken_only_where_its_condition_holds() -> None:
    builder = Builder(UKWIAL)
    a, b, _ = builder.tau
    with builder.where(a > 0.0) as merged:
        builder.refuse(b > 0.0, Status.INFEASIBLE)
        value = merged(b, a)
    program = builder.program([value, 0.0, 0.0, 0.0], Status.SOLVED)
    answered = evaluate(program, np.array([[1.0, 1, 0], [1, -1, 0], [-1, 1, 0]]))
    assert answered.status.tolist() == [2, 0, 0]
    assert answered.F[1:, 0].tolist() == [-1.0, -1.0]


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize("kernel", STRAIGHT)
def test_a_program_answers_many_demands_as_its_method_in_python_does(kernel, limits) -> None:
    """Two ways: tables and numpy's matrix products there, the graph here; rounding apart, the same."""
    vehicle = load_vehicle("bluerov2-heavy")
    demands = build_demands("jolts" if limits == "call" else "active", vehicle, 2, 80)
    low, high = demands.limits
    F, status = build(kernel, vehicle).many(demands.taus, low, high)
    given = (low, high) if limits == "call" else ()
    answered = evaluate(recipe(kernel).program(vehicle, limits), demands.taus, *given)
    np.testing.assert_array_equal(answered.status, status)
    some = status < Status.INFEASIBLE
    np.testing.assert_allclose(answered.F[some], F[some], rtol=0, atol=1e-11 * vehicle.f_scale)


def test_the_steps_of_three_dimensions_answer_as_python_does() -> None:
    vehicle = load_vehicle("supply-vessel")
    taus = build_demands("active", vehicle, 2, 200).taus
    F, status = build("nullspace", vehicle).many(taus)
    answered = evaluate(recipe("nullspace").program(vehicle), taus)
    np.testing.assert_array_equal(answered.status, status)
    np.testing.assert_allclose(answered.F, F, rtol=0, atol=1e-10 * vehicle.f_scale)


def test_a_loop_over_data_is_not_evaluated_and_says_so() -> None:
    with pytest.raises(NotApplicable, match="loop over data"):
        evaluate(recipe("redistribute").program(UKWIAL), np.zeros((1, 3)))


def test_minimum_and_maximum_take_their_second_operand_where_one_is_no_number() -> None:
    builder = Builder(UKWIAL)
    a, b, _ = builder.tau
    program = builder.program([least(a, b), most(a, b), 0.0, 0.0], Status.SOLVED)
    F = evaluate(program, np.array([[np.nan, 1.0, 0], [1.0, np.nan, 0]])).F
    np.testing.assert_array_equal(F[:, :2], [[1.0, 1.0], [np.nan, np.nan]])
