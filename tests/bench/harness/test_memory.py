"""Memory of an allocator and of a process."""

import sys
from types import SimpleNamespace

import numpy as np

from alloc import load_vehicle
from bench.harness.worker import peak_rss_bytes, reachable_bytes


def test_an_array_counts_once_however_often_it_is_held() -> None:
    array = np.zeros(10_000)
    once, twice = (
        reachable_bytes(SimpleNamespace(a=array)),
        reachable_bytes(SimpleNamespace(a=array, b=[array])),
    )
    assert once > array.nbytes
    assert twice - once < 500  # a list and a key


def test_a_view_counts_with_the_whole_array_that_it_keeps_alive() -> None:
    assert reachable_bytes(SimpleNamespace(a=np.zeros(10_000)[:1])) > 80_000


def test_what_a_closure_holds_is_counted_without_code_and_the_vehicle() -> None:
    held, vehicle = np.zeros(10_000), load_vehicle("nautilus")

    def call() -> object:
        return held, vehicle, np

    assert 80_000 < reachable_bytes(call) < 80_000 + 10 * sys.getsizeof(call)


def test_a_name_that_a_closure_knows_and_nothing_was_ever_given_is_no_error() -> None:
    """A plug-in that prepares a matrix for some vehicles only was said to have failed: Cell is empty."""
    held = np.zeros(10_000)

    def made(n: int) -> object:
        if n == 8:
            weights = held

        return lambda tau: weights @ tau if n == 8 else held

    assert reachable_bytes(made(6)) > 80_000


def test_peak_memory_only_rises() -> None:
    before = peak_rss_bytes()
    block = np.ones(4_000_000)  # touched, so resident
    after = peak_rss_bytes()
    if before is not None and after is not None:  # told by Linux only
        assert after >= before
        assert after >= block.nbytes
