"""Methods that crash, hang, leak or lie when they are called are rows with a reason; others are measured."""

import os
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from bench.__main__ import cli
from bench.record import Cell, Record, read
from bench.results.ranking import is_right
from bench.results.rows import gather
from tests.places import ROOT
from tests.plugin_files import BODIES, limited_when_stuck, write_plugin

TIME_LIMIT_S = 0.2


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Record]:
    folder = tmp_path_factory.mktemp("misbehaviour")
    plugins = [f"--plugin={write_plugin(folder, name)}" for name in BODIES]
    options = ["--vehicle=ukwial", "--demands=inactive", "--demands=infeasible", "--method=pinv"]
    tiny = ["--n=8", "--budget-ms=1", "--repeats=1", f"--time-limit={TIME_LIMIT_S}", "--memory=500"]
    command = ["run", *plugins, *options, *tiny, f"--out={folder / 'out'}"]
    with limited_when_stuck(folder):
        result = CliRunner().invoke(cli, command, standalone_mode=False)
    return result, read(folder / "out")


def cell(outcome: tuple[Result, Record], method: str, demands: str) -> Cell:
    (only,) = [c for c in outcome[1].cells if (c.key.method, c.key.demands) == (method, demands)]
    return only


@pytest.mark.parametrize(
    ("method", "status", "reason"),
    [
        ("segfaults", "crashed", "SIGSEGV"),
        ("loops", "timeout", f"no answer within {TIME_LIMIT_S:g} s"),
        ("raises", "failed", "ValueError: no such demand"),
        ("leaks", "failed", "out of memory"),
        ("exits", "crashed", "exit code 0"),
        ("calls-exit", "failed", "SystemExit: 3"),
    ],
)
def test_a_call_that_goes_wrong_is_a_row_with_its_reason_and_the_methods_other_row_is_measured(
    outcome: tuple[Result, Record], method: str, status: str, reason: str
) -> None:
    bad = cell(outcome, method, "infeasible")
    assert bad.status == status
    assert reason in bad.reason
    good = cell(outcome, method, "inactive")
    assert good.status == "ok", good.reason
    assert good.judged is not None
    assert good.judged.agrees is True


def test_methods_that_answer_are_measured_beside_those_that_do_not(outcome: tuple[Result, Record]) -> None:
    for method in ("pinv", "noop", "sleeps", "floods"):
        for demands in ("inactive", "infeasible"):
            assert cell(outcome, method, demands).status == "ok"


def test_a_plug_in_is_counted_in_what_a_vehicle_s_methods_serve_as_the_catalogue_s_are(
    outcome: tuple[Result, Record],
) -> None:
    (capability,) = outcome[1].capabilities
    shares = {(s.method, s.fault): (s.n_demands, s.within_1pct) for s in capability.served}
    states = {served.fault for served in capability.served}
    assert len(states) == 2  # whole, and after the worst failure
    for fault in states:
        assert shares["off", fault] == shares["pinv", fault]  # a thousandth is within 1 %
    assert {"off", "pinv"} <= {curve.method for curve in capability.curves}


@pytest.mark.parametrize(
    ("method", "status", "reason"),
    [
        ("segfaults", "crashed", "SIGSEGV"),
        ("loops", "timeout", f"no answer within {TIME_LIMIT_S:g} s"),
        ("raises", "failed", "ValueError: no such demand"),
        ("leaks", "failed", "out of memory"),
        ("exits", "crashed", "exit code 0"),
    ],
)
def test_a_plug_in_that_goes_wrong_while_its_share_is_counted_is_unserved_with_its_reason(
    outcome: tuple[Result, Record], method: str, status: str, reason: str
) -> None:
    (capability,) = outcome[1].capabilities
    (unserved,) = [u for u in capability.unserved if u.method == method]
    assert unserved.status == status
    assert reason in unserved.reason
    assert method not in {served.method for served in capability.served}


def test_an_array_handed_out_twice_is_a_wrong_answer(outcome: tuple[Result, Record]) -> None:
    judged = cell(outcome, "yesterday", "inactive").judged
    assert judged is not None
    assert "shares memory" in judged.wrong


def test_a_demand_that_a_method_writes_into_is_judged_as_it_was_asked(outcome: tuple[Result, Record]) -> None:
    judged = cell(outcome, "scribbles", "infeasible").judged
    assert judged is not None
    assert "the wrench is not met" in judged.wrong
    assert judged.wrong.endswith("it writes into what it is given, which is the caller's")
    assert judged.loss["lost_wrench_max"] == 1.0


def test_a_vehicle_that_a_method_writes_into_is_judged_as_it_was_given(
    outcome: tuple[Result, Record],
) -> None:
    for demands in ("inactive", "infeasible"):
        judged = cell(outcome, "changes-its-vehicle", demands).judged
        assert judged is not None
        assert "the wrench is not met" in judged.wrong


def test_nan_that_claims_to_be_solved_is_a_wrong_answer(outcome: tuple[Result, Record]) -> None:
    judged = cell(outcome, "nan", "infeasible").judged
    assert judged is not None
    assert judged.wrong.startswith("NaN")


def test_a_method_that_is_off_by_a_thousandth_is_named_and_the_exit_code_is_1(
    outcome: tuple[Result, Record],
) -> None:
    result, _ = outcome
    judged = cell(outcome, "off", "inactive").judged
    assert judged is not None
    assert judged.agrees is False
    assert "off on ukwial, inactive demands" in result.output
    assert result.return_value == 1


def test_a_method_that_is_off_after_a_failure_only_is_wrong_in_each_row_and_named_once(
    outcome: tuple[Result, Record],
) -> None:
    result, record = outcome
    rows = [row for row in gather(record) if row.method == "off-after-a-failure"]
    assert [row.failed for row in rows] == [None, None]
    for row in rows:
        assert row.agreed is not False
        assert not is_right(row)
    (line,) = [
        line for line in result.output.splitlines() if line.startswith("off-after-a-failure on ukwial")
    ]
    assert re.search(r"demands drawn evenly with thruster \d off: SOLVED, but the wrench is not met", line)
    (capability,) = record.capabilities
    assert not {"pinv", "noop", "sleeps", "floods"} & capability.wrong.keys()


def test_a_method_that_is_wrong_along_an_axis_alone_is_found(outcome: tuple[Result, Record]) -> None:
    """No demand that is drawn at random has one entry alone, and autopilots ask for little else."""
    (capability,) = outcome[1].capabilities
    assert capability.wrong["wrong-along-an-axis"].startswith(
        "on one axis or two: SOLVED, but the wrench is not met ("
    )


def test_a_sleep_counts_on_the_wall_clock_and_not_on_the_cpu_clock(outcome: tuple[Result, Record]) -> None:
    for batch in cell(outcome, "sleeps", "inactive").batches:
        assert batch.wall_ns >= 3e6 * batch.calls
        assert batch.cpu_ns < batch.wall_ns / 2


def test_no_worker_outlives_the_run(outcome: tuple[Result, Record]) -> None:
    import psutil

    assert not [
        p for p in psutil.Process(os.getpid()).children() if "bench.harness.worker" in " ".join(p.cmdline())
    ]


@pytest.mark.long
def test_proxqp_started_from_a_result_it_does_not_have_is_a_row_with_a_reason(tmp_path: Path) -> None:
    pytest.importorskip("proxsuite")
    study = ROOT / "docs" / "studies" / "proxqp_previous.py"
    options = ["--vehicle=ukwial", "--demands=active", f"--plugin={study}", "--method=pinv"]
    tiny = ["--n=8", "--budget-ms=1", "--repeats=1", "--time-limit=10", f"--out={tmp_path}"]
    result = CliRunner().invoke(cli, ["run", *options, *tiny], standalone_mode=False)
    assert result.return_value == 0, result.output  # a failure is a row, not a wrong answer
    status = {cell.key.method: cell.status for cell in read(tmp_path).cells}
    assert status["proxqp-previous"] in ("crashed", "timeout")  # it does the one or the other
    assert status["pinv"] == "ok"


@pytest.mark.usefixtures("bare_runs")
def test_a_cell_that_hung_is_not_tried_in_later_repeats_and_no_other_cell_pays_for_it(tmp_path: Path) -> None:
    plugin = write_plugin(tmp_path, "loops")
    options = ["--vehicle=ukwial", "--demands=inactive", "--demands=infeasible", f"--plugin={plugin}"]
    tiny = ["--n=4", "--budget-ms=0", "--repeats=2", f"--time-limit={TIME_LIMIT_S}"]
    with limited_when_stuck(tmp_path):
        CliRunner().invoke(cli, ["run", *options, *tiny, f"--out={tmp_path / 'out'}"], standalone_mode=False)
    rows = [c for c in read(tmp_path / "out").cells if c.key.method == "loops"]
    cells = {(c.key.demands, c.key.repeat): c for c in rows}
    assert "no answer" in cells["infeasible", 0].reason
    assert "not tried" in cells["infeasible", 1].reason
    assert cells["inactive", 0].status == cells["inactive", 1].status == "ok"
