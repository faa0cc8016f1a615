"""The least of an exact method, counted by hand."""

from alloc import load_vehicle
from alloc.reach.zonotope import zonotope
from bench.chips.bounds import least_instructions
from bench.chips.kernels import build_kernel


def test_ukwial_reads_three_writes_and_makes_four_and_looks_at_six_pairs_of_facets() -> None:
    """Its attainable set has twelve facets."""
    ukwial = load_vehicle("ukwial")
    pairs = len(zonotope(ukwial).facets) // 2
    several = sum((abs(row) > 1e-9).sum() > 1 for row in zonotope(ukwial).facets) // 2
    assert pairs == 6
    for method in ("nullspace@native", "scaled@native"):
        assert (
            least_instructions(build_kernel(method, ukwial, "float"), ukwial) == 3 + 2 * 4 + pairs + several
        )
    with_limits = build_kernel("scaled@native", ukwial, "float", "call")
    assert least_instructions(with_limits, ukwial) == 3 + 8 + 2 * 4 + pairs + several


def test_a_rule_of_practice_has_no_least() -> None:
    ukwial = load_vehicle("ukwial")
    assert least_instructions(build_kernel("clip@native", ukwial, "float"), ukwial) is None
