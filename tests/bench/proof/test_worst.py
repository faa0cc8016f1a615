"""The bound on a binary is never shorter than a call, and exact where a call takes it."""

import pytest

from alloc import load_vehicle
from alloc.program import Scalar
from bench.proof import certify, subject
from bench.proof.worst import Contradicted, worst_path
from tests.emulators import available


@pytest.mark.parametrize(
    ("kernel", "scalar", "name"), [("clip", "double", "cortex-m7"), ("scaled", "float", "cortex-m4f")]
)
def test_the_worst_call_is_the_longest_way(kernel: str, scalar: Scalar, name: str) -> None:
    """Two independent numbers are one: the emulator counts one, the graph has the other."""
    worst = worst_path(subject(load_vehicle("ukwial"), kernel, scalar, "fixed"), available(name))
    assert worst.exact
    assert str(worst) == str(worst.at_most) == str(worst.attained)
    assert worst.calls > 100
    assert max(worst.by_status.values()) == worst.attained


def test_a_way_that_no_call_takes_leaves_an_interval_that_holds_all_counts() -> None:
    """What a refused call does more and what an answered one writes never come together."""
    of = subject(load_vehicle("bluerov2"), "nullspace", "double", "fixed")
    worst = worst_path(of, available("cortex-m7"))
    assert not worst.exact
    assert worst.at_most is not None
    assert worst.attained < worst.at_most
    assert str(worst) == f"{worst.attained} … {worst.at_most}"


def test_a_call_above_the_bound_makes_a_proof_red(monkeypatch: pytest.MonkeyPatch) -> None:
    """Were the graph read wrong, the emulator would tell."""
    monkeypatch.setattr("bench.proof.worst.longest", lambda *_: 34)
    cortex = available("cortex-m7")
    monkeypatch.setattr(certify, "targets", lambda: (cortex,))
    of = subject(load_vehicle("ukwial"), "pinv", "double", "fixed")
    with pytest.raises(Contradicted, match="the longest path 34"):
        worst_path(of, cortex)
    paths, refuted, lacking = certify._paths(of)
    assert (paths, lacking) == ([], [])
    assert [(claim.claim, claim.verdict) for claim in refuted] == [(certify.WORST, "not shown")]
