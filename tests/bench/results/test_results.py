"""results.csv: the contract's columns come first, and each number is worked out in a second way."""

import csv
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter_ns
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom

from alloc import load_vehicle
from bench.harness.timing import sample, tally
from bench.judging.loss import loss
from bench.record import Batch, Cell, Judged, Key, Line
from bench.results.columns import Row, Worst
from bench.results.columns import columns as all_columns
from bench.results.quantiles import interval, share
from bench.results.rows import read_run
from bench.results.text import write_csv
from tests import made_up

CONTRACT = """
vehicle demands method start status reason n_demands n_calls setup_us call_p50_us call_p99_us call_p999_us
call_max_us solver_p50_us iterations_max solved_fraction wrench_error_max limit_violation_max_N distance_max_N
agrees peak_rss_MB quiet
"""


def test_the_contract_s_columns_come_first_in_their_order() -> None:
    assert list(all_columns())[: len(CONTRACT.split())] == CONTRACT.split()


def test_every_column_has_a_docstring() -> None:
    assert all(column.__doc__ for column in all_columns().values())


def test_a_csv_has_one_line_for_each_row_and_as_many_fields_in_each(tmp_path: Path) -> None:
    write_csv(tmp_path / "results.csv", read_run(made_up.whole(tmp_path)).table)
    with (tmp_path / "results.csv").open(newline="") as file:
        header, *lines = csv.reader(file)
    assert header == list(all_columns())
    assert len(lines) == 4
    assert {len(line) for line in lines} == {len(header)}


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("=1+2", "'=1+2"),
        ("+cmd|' /C calc'!A0", "'+cmd|' /C calc'!A0"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("-2+3", "'-2+3"),
        ("\t=1", "' =1"),
        ("-", "-"),
        ("a\x1b[2Jb\x00c\nd", "a [2Jb c d"),
        ("bluerov2 -f2", "bluerov2 -f2"),
    ],
)
def test_text_in_a_csv_is_no_formula_and_moves_no_cursor(text: str, cell: str, tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", pd.DataFrame({"name": [text], "number": [-1.0]}))
    with (tmp_path / "a.csv").open(newline="") as file:
        assert list(csv.reader(file)) == [["name", "number"], [cell, "-1.0"]]


def repeats(**each: Sequence[Any]) -> list[Cell]:
    """A method's repeats, with one of these values each."""
    cells = [
        made_up.cell(**dict(zip(each, values, strict=True))) for values in zip(*each.values(), strict=True)
    ]
    return [made_up.rename(cell, repeat=i) for i, cell in enumerate(cells)]


def judgements(**each: Sequence[Any]) -> list[Judged]:
    """Judgements of ten answers, with one of these values each."""
    return [
        Judged(answers=10, counts={"SOLVED": 10}, **dict(zip(each, values, strict=True)))
        for values in zip(*each.values(), strict=True)
    ]


def calls(n: int) -> Cell:
    """Single calls of 10, 20, … ns, once each."""
    return made_up.cell(singles=[(10 * ns, 1) for ns in range(1, n + 1)])


LOST = [
    {"lost_wrench_max": lost, "answered_share": 1 - lost, "within_1pct_share": 0.5 - lost}
    for lost in (0.1, 0.3, 0.2)
]
EMPTY = {"call_p99_us": None, "call_p99_high_us": None}
COLUMNS: dict[str, tuple[list[Line], dict[str, Any]]] = {
    "the median call is that of the batches, at 1, 2 and 1 us": ([made_up.cell()], {"call_p50_us": 1.0}),
    "the median over repeats is not moved by one slow process": (
        [*repeats(us=(1, 50, 2))],
        {"call_p50_us": 2.0, "call_p50_low_us": 1.0, "call_p50_high_us": 50.0},
    ),
    "quantiles count from the fast end": (  # single calls of 1 … 20,000 ns, once each
        [made_up.cell()],
        {"call_p99_us": 19.8, "call_p999_us": 19.98, "call_max_us": 20.0},
    ),
    "a quantile with fewer than ten calls beyond it is empty": (
        [calls(1000)],
        {"call_p99_us": 9.9, "call_p999_us": None},
    ),
    **{f"p99 is empty below a thousand calls: {n}": ([calls(n)], EMPTY) for n in (951, 960, 999)},
    "the worst answer of all repeats is shown": (
        [*repeats(judged=judgements(wrench_error_max=([1.0, -0.0], [4.0, 2.0]), agrees=(True, False)))],
        {"wrench_error_max": 4.0, "agrees": "no"},
    ),
    "of what repeats lose the most counts, of what they serve the least": (
        [*repeats(judged=judgements(loss=LOST))],
        {"lost_wrench_max": 0.3, "answered_share": 0.7, "within_1pct_share": 0.2},
    ),
    "shares stand level by level, and the least of all repeats counts": (
        [*repeats(judged=judgements(share_p50=[[1.0, 0.5]] * 2, share_min=([1.0, 0.25], [0.5, 0.5])))],
        {"share_p50": "1 0.5", "share_min": "0.5 0.25"},
    ),
    "one failed repeat makes the row failed with its reason": (
        [*repeats(status=("ok", "crashed"), reason=("", "signal 11"))],
        {"status": "crashed", "reason": "signal 11"},
    ),
    "the solved fraction counts every answer": ([made_up.cell()], {"solved_fraction": 0.9}),
    "memory is the peak of the method's own workers": (
        [made_up.worker("pinv"), made_up.worker("other", peak_rss_bytes=99_000_000), made_up.cell()],
        {"peak_rss_MB": 60.0},
    ),
    "calls are counted in batches and singly": (
        [made_up.cell(batches=[Batch(100, 1, 1, 0)] * 2, singles=[(1, 3), (2, 4)])],
        {"n_calls": 207},
    ),
}


@pytest.mark.parametrize(("lines", "expected"), COLUMNS.values(), ids=COLUMNS.keys())
def test_a_column_is_worked_out_as_its_name_says(
    lines: list[Line], expected: dict[str, Any], tmp_path: Path
) -> None:
    (only,) = made_up.run(tmp_path, *lines).rows
    assert {name: getattr(only, name) for name in expected} == pytest.approx(expected)


@pytest.mark.parametrize(("slow_ns", "times"), [(0, 1), (10**12, 2)])  # a busy machine has no say in it
def test_a_call_counts_once_although_a_slow_one_is_stored_in_a_batch_and_singly(
    slow_ns: int, times: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("bench.harness.timing.SLOW_NS", slow_ns)
    made = 0

    def call(_: int) -> None:
        nonlocal made
        made += 1
        end = perf_counter_ns() + 20_000
        while perf_counter_ns() < end:
            pass

    samples = sample(call, [range(10)], budget_ns=20_000_000)
    cell = made_up.cell(batches=samples.batches, singles=tally(samples.singles), timed_ns=samples.timed_ns)
    (only,) = made_up.run(tmp_path, cell).rows
    n = only.n_calls
    assert isinstance(n, int)
    assert n <= made
    assert n == times * len(samples.singles)


def test_floats_without_decimals_are_written_with_a_point(tmp_path: Path) -> None:
    # polars guesses a column's type from its first rows: after "1" there it refuses "0.55" further down.
    cells = [made_up.cell("a", us=1), made_up.cell("b", us=3, setup_ns=[1500])]
    write_csv(tmp_path / "results.csv", made_up.run(tmp_path, *cells).table)
    with (tmp_path / "results.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["call_p50_us"] for line in lines] == ["1.0", "3.0"]
    assert [line["setup_us"] for line in lines] == ["6.0", "1.5"]
    assert [line["n_demands"] for line in lines] == ["10", "10"]


def test_a_degraded_vehicle_has_sections_of_its_own_only_where_the_whole_one_was_not_measured(
    tmp_path: Path,
) -> None:
    problems = [
        made_up.problem("a"),
        made_up.problem("a-f2", whole="a", fault=2),
        made_up.problem("a-fast"),
        made_up.problem("b-f0", whole="b", fault=0),
        made_up.problem("growth-rov"),
        made_up.problem("growth-k3-n4", study="growth"),
    ]
    cells = [made_up.cell(key=Key(p.vehicle, "active", "pinv")) for p in problems]
    run = made_up.run(tmp_path, *problems, *cells)
    assert run.vehicles == ["a", "a-fast", "b-f0", "growth-rov"]
    assert run.degraded == ["a-f2"]


@pytest.mark.parametrize(("hits", "n"), [(0, 20), (20, 20), (7, 20), (1300, 2000)])
def test_the_interval_of_a_share_is_clopper_and_pearson_s(hits: int, n: int) -> None:
    """By its definition: at either end, as many hits or more extreme numbers have a probability of 2.5 %."""
    middle, low, high = share(hits, n)
    assert middle == hits / n
    assert low == 0.0 if hits == 0 else binom.sf(hits - 1, n, low) == pytest.approx(0.025)
    assert high == 1.0 if hits == n else binom.cdf(hits, n, high) == pytest.approx(0.025)


@pytest.mark.parametrize("q", [0.5, 0.99, 0.999])
@pytest.mark.parametrize("n", [20_000, 123_457])
def test_the_interval_of_a_quantile_has_binomial_ranks(n: int, q: float) -> None:
    """At most as many of n calls as the low rank lie below the quantile with 2.5 %, and fewer with less."""
    low, high = interval([(ns, 1) for ns in range(1, n + 1)], q) or (0, 0)
    for rank, p in ((low, 0.025), (high - 1, 0.975)):
        assert binom.cdf(rank - 1, n, q) < p <= binom.cdf(rank, n, q)


def test_a_column_without_a_function_is_a_loss_that_is_worked_out() -> None:
    """A misspelt name would be a column that is empty for ever."""
    vehicle = load_vehicle("ukwial")
    known = loss(vehicle, np.zeros((1, vehicle.k)), np.zeros((1, vehicle.n)), np.zeros((1, vehicle.n)))
    named = {name for name, column in vars(Row).items() if isinstance(column, Worst) and column.of is None}
    assert len(named) > 10
    assert named <= set(known)
