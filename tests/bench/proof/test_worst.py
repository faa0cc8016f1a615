"""The bound on a binary is never shorter than a call, and exact where a call takes it."""

import numpy as np
import pytest
from msgspec.structs import replace

from alloc import load_vehicle
from alloc.program import Scalar
from bench.proof import subject, worst
from bench.proof.worst import WORST, Contradicted, counted_before, worst_path, worst_paths
from bench.record import Emulated
from tests.emulators import available


@pytest.mark.parametrize(
    ("kernel", "scalar", "name"), [("clip", "double", "cortex-m7"), ("clip", "float", "cortex-m4f")]
)
def test_the_worst_call_is_the_longest_way(kernel: str, scalar: Scalar, name: str) -> None:
    """Two independent numbers are one: the emulator counts one, the graph has the other."""
    found = worst_path(subject(load_vehicle("ukwial"), kernel, scalar, "fixed"), available(name))
    assert found.exact
    assert str(found) == str(found.at_most) == str(found.attained)
    assert found.calls > 100
    assert max(found.by_status.values()) == found.attained


def test_a_way_that_no_call_takes_leaves_an_interval_that_holds_all_counts() -> None:
    """Extra work of a refused call and writes of an answered one never come together."""
    of = subject(load_vehicle("bluerov2"), "nullspace", "double", "fixed")
    found = worst_path(of, available("cortex-m7"))
    assert not found.exact
    assert found.at_most is not None
    assert found.attained < found.at_most
    assert str(found) == f"{found.attained} … {found.at_most}"


def test_a_proof_asks_again_what_emulate_found_costly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without calls of its own it takes the one of the record; another precision's counts for nothing."""
    monkeypatch.setattr("bench.proof.worst.extremes", lambda vehicle, *_: np.full((2, vehicle.k), np.nan))
    monkeypatch.setattr("bench.proof.worst.climb", lambda *_: None)
    of, cortex = subject(load_vehicle("ukwial"), "clip", "double", "fixed"), available("cortex-m7")
    row = Emulated("ukwial", "cortex-m7", "clip@native", "double", worst=[300.0, 20.0, 1.0])
    before = counted_before([row, replace(row, scalar="float", worst=[1.0, 1.0, 1.0])], of)
    assert before == {"cortex-m7": [[300.0, 20.0, 1.0]]}
    alone, with_it = worst_path(of, cortex), worst_path(of, cortex, before)
    assert with_it.calls == alone.calls + 1
    assert alone.attained < with_it.attained
    assert with_it.tau == row.worst


def test_a_call_above_the_bound_makes_a_proof_red(monkeypatch: pytest.MonkeyPatch) -> None:
    """Were the graph read wrong, the emulator would tell."""
    monkeypatch.setattr("bench.proof.worst.bound", lambda *_: 34)
    cortex = available("cortex-m7")
    monkeypatch.setattr(worst, "processors", lambda: (cortex,))
    of = subject(load_vehicle("ukwial"), "pinv", "double", "fixed")
    with pytest.raises(Contradicted, match="the longest path 34"):
        worst_path(of, cortex)
    paths, refuted, lacking = worst_paths(of, {})
    assert (paths, lacking) == ([], [])
    assert [(claim.claim, claim.verdict) for claim in refuted] == [(WORST, "not shown")]
