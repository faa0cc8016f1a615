"""Exports of ``alloc`` and ``alloc.plugin``, and the truth value of an Allocation."""

from math import nan

import numpy as np
import pytest

import alloc
import alloc.plugin
from alloc import Allocation, Status


def test_no_name_stands_in_two_doors() -> None:
    assert set(alloc.__all__).isdisjoint(alloc.plugin.__all__)


def test_a_name_that_never_was_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'alloc' has no attribute 'allocate'"):
        _ = alloc.allocate  # type: ignore[attr-defined]
    with pytest.raises(ImportError):
        from alloc import allocate  # type: ignore[attr-defined]  # noqa: F401


@pytest.mark.parametrize("status", Status)
def test_thrusts_are_found_with_the_statuses_that_promise_them(status: Status) -> None:
    f = np.zeros(2) if status in (Status.SOLVED, Status.PARTIAL) else np.full(2, nan)
    assert Allocation(f, status).found is bool(np.isfinite(f).all())


@pytest.mark.parametrize("status", Status)
def test_an_allocation_is_neither_true_nor_false(status: Status) -> None:
    with pytest.raises(TypeError, match=r"ask result\.found .*result\.status == Status\.SOLVED"):
        bool(Allocation(np.zeros(2), status))
