"""The report says what a failure costs until somebody knows: by thruster, by method, in a picture."""

import re
from pathlib import Path

import msgspec
import pytest

from alloc import load_vehicle
from bench.judging.capability import measure_capabilities
from bench.judging.question import ask_here
from bench.record import Capability, FailureCost
from bench.report.page import details
from bench.report.pictures import draw_all
from bench.report.pictures import unannounced as pictured
from bench.report.sections.headline import headline
from bench.report.sections.unannounced import unannounced
from bench.results.failures import failure_sentence
from bench.results.rows import Run
from tests import made_up


@pytest.fixture(scope="module")
def measured() -> Capability:
    (capability,) = measure_capabilities([load_vehicle("ukwial")], ["pinv", "scaled"], 0, ask_here, 60)
    return capability


def run_with(tmp_path: Path, capability: Capability) -> Run:
    return made_up.run(tmp_path, made_up.problem("ukwial"), made_up.cell("pinv"), capability)


def test_the_section_has_a_line_for_each_thruster_and_method_and_the_picture(
    tmp_path: Path, measured: Capability
) -> None:
    run = run_with(tmp_path, measured)
    text = unannounced(run, draw_all(run, tmp_path))
    assert "](unannounced-ukwial.svg)" in text
    for i, share in enumerate(measured.failure_costs[0].share_p50):
        assert re.search(rf"^\| {i} +\|", text, re.MULTILINE), share
    assert "failed (scaled)" in text
    assert re.search(r"^\| (pinv|scaled|pinv, scaled) +\|", text, re.MULTILINE)
    assert "What you lose until you know" in details(run, frozenset())


def test_the_worst_demand_is_the_one_of_the_least_share_in_the_record(
    tmp_path: Path, measured: Capability
) -> None:
    text = unannounced(run_with(tmp_path, measured), frozenset())
    costs = [cost for cost in measured.failure_costs if cost.method == "scaled" and not cost.announced]
    worst = min(costs, key=lambda cost: min(cost.share_min))
    found = re.search(r"with (\d) (\w+) and nobody told: `scaled` delivers (-?[\d.]+) %", text)
    assert found is not None
    assert found[2] == worst.failure
    assert float(found[3]) == pytest.approx(100 * min(worst.share_min), rel=0.01)
    assert worst.share_min[int(found[1])] == min(worst.share_min)


def test_the_overview_says_what_the_costliest_thruster_leaves_before_and_after(
    tmp_path: Path, measured: Capability
) -> None:
    run = run_with(tmp_path, measured)
    (off,) = (
        cost
        for cost in measured.failure_costs
        if (cost.failure, cost.method, cost.announced) == ("off", "scaled", False)
    )
    found = re.search(
        r"nobody told, ([\d.]+) % of a demand is delivered, ([\d.]+) %", headline(run, frozenset())
    )
    assert found is not None
    assert float(found[1]) == pytest.approx(100 * min(off.share_p50), rel=0.01)
    (known,) = (cost for cost in measured.failure_costs if cost.failure == "off" and cost.announced)
    assert float(found[2]) == pytest.approx(
        100 * known.share_p50[off.share_p50.index(min(off.share_p50))], rel=0.01
    )


def test_a_record_of_before_has_no_such_section_or_picture(tmp_path: Path) -> None:
    run = run_with(tmp_path, made_up.capability())
    assert unannounced(run, frozenset()) == failure_sentence(run) == ""
    assert pictured.unannounced(run, "ukwial") is None


def test_costs_survive_the_record_and_a_cost_that_lacks_a_number_is_refused(
    tmp_path: Path, measured: Capability
) -> None:
    read = run_with(tmp_path, measured).capability("ukwial")
    assert read is not None
    assert read.failure_costs == measured.failure_costs
    cost = measured.failure_costs[0]
    with pytest.raises(ValueError, match="as many entries"):
        FailureCost(**(msgspec.structs.asdict(cost) | {"share_min": cost.share_min[1:]}))
