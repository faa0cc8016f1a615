"""docs/exact.md agrees with the code: its worst cases, its picture, and the tools behind its figures."""

import re
import shutil

import numpy as np
import pytest

import c_loop
import nullspace_picture
from alloc import build, load_vehicle
from alloc.c import Target, missing, sources
from alloc.methods import recipe
from bench.chips.kernels import Kernel
from tests.places import DOCS

PAGE = (DOCS / "exact.md").read_text(encoding="utf-8")
compiled = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


def kernel() -> Kernel:
    vehicle = load_vehicle("ukwial")
    target = Target(vehicle=vehicle, method=recipe("nullspace"))
    name = target.name
    return Kernel(
        method="nullspace@native",
        twin="pinv",
        scalar="double",
        k=3,
        n=4,
        entry=name,
        declaration=f'#include "{name}.h"',
        arguments="tau, -1, f",
        sources=sources(target),
    )


def test_the_page_prints_each_vehicles_worst_case() -> None:
    rows = re.findall(r"^\| (`[^|]*) \| [^|]* \| (\d+) \|$", PAGE, flags=re.MULTILINE)
    named = {name: int(steps) for names, steps in rows for name in re.findall(r"`([\w-]+)`", names)}
    assert len(named) >= 6
    for name, steps in named.items():
        assert build("nullspace", load_vehicle(name)).worst_case_steps == steps


def test_the_pictured_way_starts_at_zero_and_only_moves_away() -> None:
    axes = nullspace_picture.draw().axes[0]  # draw() itself checks that the way ends at nullspace's f
    way = next(line for line in axes.lines if len(line.get_xdata()) == 6)  # from 0 past five strips
    lengths = np.hypot(*way.get_data())
    assert lengths[0] == 0.0
    assert (np.diff(lengths) >= -1e-9).all()  # each strip can only push z away from the origin


@compiled
def test_the_c_loop_times_every_call_and_only_those() -> None:
    taus = np.zeros((50, 3))
    ns = c_loop.nanoseconds(kernel(), taus, repeats=3)
    assert len(ns) == 3
    assert (ns > 0.1).all()  # fewer than one instruction a call would mean that the call was left out
    assert (ns < 1e5).all()


@compiled
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind (Debian: apt install valgrind) counts")
def test_instruction_counts_repeat_exactly_and_differ_between_demands() -> None:
    taus = np.array([[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0], [100.0, 20.0, 5.0]])
    first, again = (c_loop.instructions(kernel(), taus) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    assert len(first) == 3
    assert first[1] != first[0]  # what is no number is answered by another way out
