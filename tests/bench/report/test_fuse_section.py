"""The report says what a cap costs: by way, by axis and in a sentence; without a cap, nothing."""

import re
from pathlib import Path

import pytest

from bench.record import Capability, CapExcess, FuseCost, FuseWay, Power
from bench.report.page import page
from bench.report.sections.fuse import fuse
from bench.report.verdict import fuse_notes
from bench.results.rows import Run
from tests import made_up


def way(name: str, share: float) -> FuseWay:
    ends = {"axis_min": [-3.0 * share, -2.0, -1.0], "axis_max": [4.0 * share, 2.0, 1.0]}
    return FuseWay(way=name, share_p50=share, share_min=share / 2, amps_p50=1.25, amps_max=1.5, **ends)


@pytest.fixture
def capped() -> Capability:
    ways = [way("largest", 1.0), way("apart", 0.5)]
    powers = [Power(demands="mission", n=100, seconds=1800.0, effort_W=100.0, least_W=98.0)]
    excesses = [CapExcess(way="limiter", over_A=12.5, over_share=0.1, share_p50=0.9, share_min=0.25)]
    numbers = {"amps": 22.0, "volts": 12.0, "most": 137.0, "last_amps": 13.2, "n_demands": 100}
    cost = FuseCost(**numbers, ways=ways, powers=powers, excesses=excesses)
    return made_up.capability(fuse=cost)


def run_with(tmp_path: Path, capability: Capability) -> Run:
    return made_up.run(tmp_path, made_up.problem("ukwial"), made_up.cell("pinv"), capability)


def test_the_section_has_shares_currents_and_the_most_along_each_axis(
    tmp_path: Path, capped: Capability
) -> None:
    run = run_with(tmp_path, capped)
    text = fuse(run, frozenset())
    assert "### ukwial, 22.0 A of 137 A at 12 V" in text
    assert re.search(r"\| apart +\| +50.0 % +\| +25.0 % +\| +125 % +\| +150 % +\|", text)
    assert re.search(r"\| apart +\| -1.50 … 2.00 +\| ± 2.00 +\| ± 1.00 +\|", text)
    energy = "50 Wh by least effort, 49 Wh at least current: 2 % less"
    assert f"mission, 1800 s, by 100 of its demands: {energy}" in text
    assert "while the cap falls from 22.0 to 13.2 A" in text
    assert re.search(r"\| limiter +\| +12.5 +\| +10.0 % +\| +90.0 % +\| +25.0 % +\|", text)
    assert text in page(run, frozenset())


def test_the_overview_says_what_each_way_but_the_largest_delivers(tmp_path: Path, capped: Capability) -> None:
    (said,) = fuse_notes(run_with(tmp_path, capped))
    assert said.startswith("ukwial: the cap leaves 22.0 A of 137 A.")
    assert said.endswith("apart 50.0 %.")
    assert "largest 100" not in said


def test_the_cost_survives_the_record_and_a_vehicle_without_a_cap_has_no_section(
    tmp_path: Path, capped: Capability
) -> None:
    read = run_with(tmp_path, capped).capability("ukwial")
    assert read is not None
    assert read.fuse == capped.fuse
    run = run_with(tmp_path, made_up.capability())
    assert fuse(run, frozenset()) == ""
    assert fuse_notes(run) == []
