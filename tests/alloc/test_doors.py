"""Old names of ``alloc`` go on working for a release; what an Allocation says of itself."""

from importlib import import_module
from math import nan

import numpy as np
import pytest

import alloc
import alloc.plugin
from alloc import Allocation, Status

OLD = [
    *((name, module) for module, names in alloc.MOVED.items() for name in names),
    *((name, "alloc.plugin") for name in alloc.plugin.__all__),
]


@pytest.mark.parametrize(("name", "module"), OLD)
def test_an_old_name_still_works_and_says_where_it_is_now(name: str, module: str) -> None:
    with pytest.warns(DeprecationWarning, match=rf"from {module} import {name}$") as warned:
        old = getattr(alloc, name)
    assert old is getattr(import_module(module), name)
    assert warned[0].filename == __file__


def test_no_name_stands_in_two_doors() -> None:
    moved = {name for name, _ in OLD}
    assert len(moved) == len(OLD)
    assert moved.isdisjoint(alloc.__all__)
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
