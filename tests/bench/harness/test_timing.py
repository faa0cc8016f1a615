"""Timing: whole passes in order, batches that are long enough, times that are stored to a percent."""

import gc
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.harness import worker
from bench.harness.timing import BATCH_NS, SLOW_NS, no_garbage_collection, sample, tally
from bench.record.measured import binned

INPUTS = list(range(7))


def test_answers_come_in_whole_passes_and_in_order() -> None:
    samples = sample(lambda x: x, [INPUTS], budget_ns=10_000_000)
    assert len(samples.answers) % len(INPUTS) == 0
    assert samples.answers == INPUTS * (len(samples.answers) // len(INPUTS))


def test_every_call_outside_warm_up_is_in_a_sample_and_every_batch_is_a_multiple_of_the_inputs() -> None:
    calls = 0

    def call(_: int) -> None:
        nonlocal calls
        calls += 1

    samples = sample(call, [INPUTS], budget_ns=10_000_000)
    assert samples.batches
    assert all(batch.calls % len(INPUTS) == 0 for batch in samples.batches)
    assert len({batch.calls for batch in samples.batches}) == 1
    assert sum(batch.calls for batch in samples.batches) + len(samples.singles) <= calls


def test_batches_of_a_fast_call_last_about_as_long_as_they_should() -> None:
    def call(_: int) -> int:
        return sum(range(100))  # 1 to 5 us

    samples = sample(call, [INPUTS], budget_ns=20_000_000)
    quickest = min(batch.wall_ns for batch in samples.batches)  # a longer one may have been interrupted
    assert BATCH_NS / 4 < quickest < BATCH_NS * 2


def test_the_first_pass_of_a_fast_call_ran_on_cold_caches_and_is_no_sample() -> None:
    samples = sample(lambda _: None, [INPUTS], budget_ns=0, singles=0)
    assert samples.singles == []
    assert samples.batches


def test_a_slow_call_is_timed_singly_and_each_pass_is_a_batch_too() -> None:
    def call(_: int) -> None:
        time.sleep(4 * SLOW_NS / 1e9)

    samples = sample(call, [INPUTS], budget_ns=0)
    assert len(samples.singles) == len(INPUTS) == samples.batches[0].calls
    assert samples.batches[0].wall_ns == sum(samples.singles) == samples.timed_ns
    assert min(samples.singles) >= 4 * SLOW_NS
    assert samples.batches[0].cpu_ns < samples.batches[0].wall_ns  # sleep takes no CPU time


def test_the_budget_is_kept_roughly_and_singles_are_bounded() -> None:
    start = time.perf_counter_ns()
    samples = sample(lambda _: None, [INPUTS], budget_ns=50_000_000, singles=100)
    assert time.perf_counter_ns() - start < 2_000_000_000  # ample for a busy machine
    assert len(samples.singles) < 100 + BATCH_NS // 10  # one round more, of calls of 10 ns at least


@given(st.integers(1, 10**11))
def test_a_stored_time_is_at_most_one_percent_off(ns: int) -> None:
    assert abs(binned(ns) - ns) <= 0.01 * ns + 0.5  # half a bin, and whole nanoseconds


@given(st.lists(st.integers(0, 10**9), max_size=50))
def test_a_histogram_loses_no_call_and_is_sorted(times: list[int]) -> None:
    histogram = tally(times)
    assert sum(count for _, count in histogram) == len(times)
    assert histogram == sorted(histogram)
    assert len({ns for ns, _ in histogram}) == len(histogram)


def test_the_garbage_collector_is_off_inside_the_block_and_on_again_after_an_error() -> None:
    states = []

    def fail() -> None:
        with no_garbage_collection():
            states.append(gc.isenabled())
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert [*states, gc.isenabled()] == [False, True]


def test_a_slow_build_is_repeated_only_where_it_imports_the_method(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Generated C takes a third of a second a build, which every cell paid twice."""
    monkeypatch.setattr(worker, "SETUP_NS", 0)
    for least in (1, 2):
        built: list[int] = []
        allocator, times = worker.set_up(lambda built=built: built.append(1) or len(built), least)
        assert (allocator, len(built), len(times)) == (least, least, least)
