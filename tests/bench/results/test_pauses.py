"""A late call is the method's or the machine's."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from bench.record import Batch, Cell, Key, Method
from bench.results.quantiles import Tally
from bench.results.size import LATE_SHARE, Fit, Loop
from bench.results.sizing import CHANCE, Pauses, find_pauses, machine_excuse, sizes
from tests import made_up
from tests.bench.results.test_sizing import steady

LIMIT_US = 1000.0
QUIET = Pauses([], 10**9)


def test_fixed_work_s_pauses_are_what_it_took_beyond_its_median(tmp_path: Path) -> None:
    """Ten calls of 100 ns and one of 5,100 ns: one pause of 5,000 ns in 6,100 ns."""
    noop = made_up.cell("noop", singles=[(100, 10), (5100, 1)])
    slow = made_up.cell("pinv", singles=[(9000, 3)])  # a method's own times say nothing of the machine
    yardstick = Method(name="noop", yardstick=True)
    esc = made_up.cell("esc", singles=[(90, 9), (8000, 9)])  # nor do those of a board's NAME_esc
    esc.worst = [1.0]
    both = (yardstick, Method(name="esc", yardstick=True))
    found = find_pauses(made_up.run(tmp_path, *both, noop, slow, esc))
    assert found == Pauses([(5000, 1)], 6100)
    assert [found.late(limit_us, 10.0) for limit_us in (10, 14.999, 15)] == [1, 1, 0]


def test_all_late_calls_of_bounded_steps_are_the_machine_s_where_the_bound_fits() -> None:
    """A hundred steps, each as long as a median call of 10 µs, just fit 1,000 µs; 101 do not."""
    late = [(10_000, 10_000), (2_000_000, 50)]
    assert (
        machine_excuse(Tally(late), 50, LIMIT_US, 10.0, 100, QUIET)
        == "its steps are bounded, so the machine was late"
    )
    assert machine_excuse(Tally(late), 50, LIMIT_US, 10.0, 101, QUIET) == ""


def test_one_late_call_of_bounded_steps_is_the_machine_s_and_two_are_not() -> None:
    """The same demands were asked again and again: the steps of one would make many calls late."""
    singles = [(900_000, 10_000), (2_000_000, 2)]
    assert (
        machine_excuse(Tally(singles), 1, LIMIT_US, 900.0, 50, QUIET)
        == "its steps are bounded, so the machine was late"
    )
    assert machine_excuse(Tally(singles), 2, LIMIT_US, 900.0, 50, QUIET) == ""


def test_without_a_pause_of_fixed_work_nothing_else_is_excused() -> None:
    assert machine_excuse(Tally([(10_000, 10_000), (2_000_000, 1)]), 1, LIMIT_US, 10.0, None, QUIET) == ""


def test_a_pause_of_fixed_work_counts_only_where_it_is_as_long() -> None:
    singles = [(10_000, 10_000), (2_000_000, 1)]  # late by a pause of at least 990 µs
    assert machine_excuse(Tally(singles), 1, LIMIT_US, 10.0, None, Pauses([(990_000, 1)], 10**8)) == ""
    assert (
        machine_excuse(Tally(singles), 1, LIMIT_US, 10.0, None, Pauses([(990_001, 1)], 10**8))
        == "fixed work was late as often, so the machine was"
    )


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 15), st.integers(1, 20), st.floats(0.01, 0.99))
def test_late_calls_are_excused_as_long_as_chance_allows(late: int, seen: int, share: float) -> None:
    """The chance that so many of all pauses hit the method, summed term by term."""
    from math import comb

    took = 10**9
    fixed = Pauses([(10**7, seen)], round(took * (1 - share) / share))
    n = late + seen
    share = took / (took + fixed.exposure_ns)
    chance = sum(comb(n, k) * share**k * (1 - share) ** (n - k) for k in range(late, n + 1))
    calls = 100_000
    verdict = machine_excuse(Tally([(took // calls, calls)]), late, LIMIT_US, 10.0, None, fixed)
    assert (verdict == "fixed work was late as often, so the machine was") == (chance >= CHANCE)


def test_what_is_late_more_often_than_a_fitting_method_may_be_is_not_excused_by_canaries() -> None:
    """Else a machine that pauses all the time would make everything fit."""
    fixed = Pauses([(10**7, 10**6)], 10**9)
    singles = [(10_000, 100_000)]
    most = round(LATE_SHARE * 100_000)
    assert (
        machine_excuse(Tally(singles), most, LIMIT_US, 10.0, None, fixed)
        == "fixed work was late as often, so the machine was"
    )
    assert machine_excuse(Tally(singles), most + 1, LIMIT_US, 10.0, None, fixed) == ""


@pytest.mark.parametrize("pause_us", [None, 5_000.0, 40_000.0])
def test_one_pause_of_the_machine_turns_no_verdict_and_is_shown(
    pause_us: float | None, tmp_path: Path
) -> None:
    """The exact method of bounded steps stays first, whatever hit one of its calls."""
    bounded = steady("bounded", 2, exact=True, slowest_us=pause_us)
    cells = [replace(bounded, worst_case_steps=20), steady("solver", 9, exact=True)]
    first, _ = sizes(made_up.run(tmp_path, *cells), Loop(100))
    assert (first.label, first.fit) == ("bounded", Fit.FITS)
    assert first.reason == ("" if pause_us is None else "its steps are bounded, so the machine was late")
    assert first.late == (0 if pause_us is None else 1)


@pytest.mark.parametrize(("bounded_us", "first"), [(5, "bounded"), (14, "bounded"), (16, "solver")])
def test_of_medians_that_are_close_the_one_with_a_known_worst_case_comes_first(
    bounded_us: float, first: str, tmp_path: Path
) -> None:
    """A busy machine swaps 10 µs and 14 µs from run to run; 16 µs is another class."""
    cells = [
        replace(steady("bounded", bounded_us, exact=True), worst_case_steps=20),
        steady("solver", 10, exact=True),
    ]
    found = sizes(made_up.run(tmp_path, *cells), Loop(10_000, 0.5))
    assert found[0].label == first


@pytest.mark.parametrize(("late", "first"), [(1, "a"), (12, "a"), (30, "bb")])
def test_a_tail_counts_where_it_is_surely_late_and_not_for_a_few_calls(
    late: int, first: str, tmp_path: Path
) -> None:
    """Ten of 10,000 calls may be late; twelve are chance, thirty are not."""
    cell = replace(steady("a", 2, exact=True), singles=[(2_000, 10_000 - late), (2_000_000, late)])
    few = replace(steady("bb", 3, exact=True), singles=[(3_000, 100)])
    assert sizes(made_up.run(tmp_path, cell, few), Loop(100))[0].label == first


def test_methods_are_ranked_by_their_own_cpu_time_and_not_by_what_else_the_machine_did(
    tmp_path: Path,
) -> None:
    """The faster method's batches were held up in each repeat: 90 µs by the wall, 2 µs of its own."""
    held_up = replace(steady("fast", 90, exact=True), batches=[Batch(100, 9_000_000, 200_000, 40)])
    run = made_up.run(tmp_path, held_up, steady("slow", 50, exact=True))
    first, second = sizes(run, Loop(1000, 0.2))
    assert (first.label, first.p50_us, second.label) == ("fast", 90.0, "slow")


def test_no_p999_stands_below_the_median_of_a_set_that_it_leaves_out(tmp_path: Path) -> None:
    """A slow set with ten calls among 20,000 quick ones is not in their p99.9: then there is none."""
    slow = Cell(
        Key("ukwial", "infeasible", "m"),
        "ok",
        formulation="hard",
        batches=[Batch(10, 10 * 50_000, 10 * 50_000, 0)],
        singles=[(50_000, 10)],
    )
    run = made_up.run(tmp_path, steady("m", 1, exact=True), slow)
    (size,) = sizes(run, Loop(100))
    assert (size.p50_us, size.p999_us) == (50.0, None)
    assert [run.tail_us(row, 0.99) for row in run.rows] == [None, None]
