"""Methods that crash, hang, leak or lie are rows with a reason; others are measured."""

import os
import re
from pathlib import Path

import psutil
import pytest
from click.testing import CliRunner, Result

from bench.__main__ import cli
from bench.harness.process import DescribeTask, Failed, Job, work
from bench.record import Cell, Record, read
from bench.results.ranking import is_right
from bench.results.rows import gather
from tests.plugin_files import BODIES, STUCK, limited_when_stuck, write_plugin

TIME_LIMIT_S = 0.2
LATE = f"no answer within {TIME_LIMIT_S:g} s"
WITH_MANY = """
from alloc.methods.pinv import FORMULATION, build as pinv

class Allocator:
    formulation, limited, tolerance = FORMULATION, False, 1e-9

    def __init__(self, vehicle):
        self.whole = pinv(vehicle)

    def __call__(self, tau):
        return self.whole(tau)

    def many(self, taus):
        {body}

def build(vehicle):
    return Allocator(vehicle)
"""
IMPORTS = {
    "segfaults_at_once": "import ctypes; ctypes.string_at(0)",
    "hangs_at_once": f"{STUCK}; import time; time.sleep(1e6)",
    "ends_at_once": "import os; os._exit(0)",
}
MANY = {
    "segfaults_in_many": WITH_MANY.format(body="import ctypes; ctypes.string_at(0)"),
    "drops_a_thruster_in_many": WITH_MANY.format(body="F, s = self.whole.many(taus); return F[:, 1:], s"),
    "drops_a_demand_in_many": WITH_MANY.format(body="F, s = self.whole.many(taus); return F[1:], s[1:]"),
    "has_many_of_pinv": WITH_MANY.format(body="return self.whole.many(taus)"),
}


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Record]:
    """A run of all of them, beside pinv, and its record."""
    folder = tmp_path_factory.mktemp("misbehaviour")
    plugins = [write_plugin(folder, name) for name in BODIES]
    for name, text in (IMPORTS | MANY).items():
        (folder / f"{name}.py").write_text(text)
        plugins.append(str(folder / f"{name}.py"))
    options = ["--vehicle=ukwial", "--demands=inactive", "--demands=infeasible", "--method=pinv"]
    tiny = ["--n=8", "--budget-ms=1", "--repeats=1", f"--time-limit={TIME_LIMIT_S}", "--memory=500"]
    command = ["run", *(f"--plugin={each}" for each in plugins), *options, *tiny, f"--out={folder / 'out'}"]
    with limited_when_stuck(folder):
        result = CliRunner().invoke(cli, command, standalone_mode=False)
    return result, read(folder / "out")


def cell(outcome: tuple[Result, Record], method: str, demands: str) -> Cell:
    (only,) = [c for c in outcome[1].cells if (c.key.method, c.key.demands) == (method, demands)]
    return only


CALLS = {
    "segfaults": ("crashed", "SIGSEGV"),
    "loops": ("timeout", LATE),
    "raises": ("failed", "ValueError: no such demand"),
    "leaks": ("failed", "out of memory"),
    "exits": ("crashed", "exit code 0"),
}
"""Status and reason of what goes wrong in a large demand: of its row, and of its share."""
AT_ONCE = {
    "segfaults-at-once": ("crashed", "SIGSEGV"),
    "hangs-at-once": ("timeout", LATE),
    "ends-at-once": ("crashed", "exit code 0"),
}
"""The same of what goes wrong as it is imported."""
IN_MANY = {
    "segfaults-in-many": ("crashed", "SIGSEGV"),
    "drops-a-thruster-in-many": ("failed", "thrusts of shape (2000, 3)"),
    "drops-a-demand-in-many": ("failed", "thrusts of shape (1999, 4)"),
}
"""The same of a share that alone is missing, since ``many`` goes wrong."""


@pytest.mark.parametrize("method", [*CALLS, *AT_ONCE, "calls-exit"])
def test_what_goes_wrong_is_a_row_with_its_reason(outcome: tuple[Result, Record], method: str) -> None:
    status, reason = (CALLS | AT_ONCE).get(method, ("failed", "SystemExit: 3"))
    bad = cell(outcome, method, "infeasible")
    assert bad.status == status
    assert reason in bad.reason


@pytest.mark.parametrize("method", [*CALLS, *AT_ONCE, *IN_MANY])
def test_a_share_that_can_t_be_counted_is_missing_with_its_reason(
    outcome: tuple[Result, Record], method: str
) -> None:
    status, reason = (CALLS | AT_ONCE | IN_MANY)[method]
    (capability,) = outcome[1].capabilities
    (unserved,) = [u for u in capability.unserved if u.method == method]
    assert unserved.status == status
    assert reason in unserved.reason
    assert method not in {served.method for served in capability.served}


def test_methods_that_answer_are_measured_beside_those_that_do_not(outcome: tuple[Result, Record]) -> None:
    for method in ("pinv", "noop", "sleeps", "floods", *IN_MANY):
        for demands in ("inactive", "infeasible"):
            assert cell(outcome, method, demands).status == "ok"
    for method in (*CALLS, "calls-exit"):
        good = cell(outcome, method, "inactive")
        assert good.status == "ok", good.reason
        assert good.judged is not None
        assert good.judged.agrees is True
    assert outcome[1].events[-1].what == "finished"


def test_a_plug_in_is_counted_in_what_a_vehicle_s_methods_serve_as_the_catalogue_s_are(
    outcome: tuple[Result, Record],
) -> None:
    (capability,) = outcome[1].capabilities
    shares = {(s.method, s.fault): (s.n_demands, s.within_1pct) for s in capability.served}
    states = {served.fault for served in capability.served}
    assert len(states) == 2  # whole, and after the worst failure
    for fault in states:
        assert shares["off", fault] == shares["pinv", fault]  # a thousandth is within 1 %
        assert shares["has-many-of-pinv", fault] == shares["pinv", fault]
    assert {"off", "pinv"} <= {curve.method for curve in capability.curves}


@pytest.mark.parametrize(
    ("method", "demands", "says"),
    [
        ("yesterday", "inactive", "shares memory"),
        (
            "scribbles",
            "infeasible",
            "the wrench is not met.*; it writes into what it is given",
        ),
        ("changes-its-vehicle", "inactive", "the wrench is not met"),
        ("changes-its-vehicle", "infeasible", "the wrench is not met"),
        ("nan", "infeasible", "^NaN"),
    ],
)
def test_a_wrong_answer_is_judged_by_what_was_asked_and_of_which_vehicle(
    outcome: tuple[Result, Record], method: str, demands: str, says: str
) -> None:
    judged = cell(outcome, method, demands).judged
    assert judged is not None
    assert re.search(says, judged.wrong)
    assert method != "scribbles" or judged.loss["lost_wrench_max"] == 1.0


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
        assert batch.wall_ns >= 1e6 * batch.calls
        assert batch.cpu_ns < batch.wall_ns / 2


def test_no_worker_outlives_the_run(outcome: tuple[Result, Record]) -> None:
    assert not [
        p for p in psutil.Process(os.getpid()).children() if "bench.harness.worker" in " ".join(p.cmdline())
    ]


@pytest.mark.usefixtures("bare_runs")
def test_a_cell_that_hung_is_not_tried_in_later_repeats_and_no_other_cell_pays_for_it(tmp_path: Path) -> None:
    plugin = write_plugin(tmp_path, "loops")
    options = ["--vehicle=ukwial", "--demands=inactive", "--demands=infeasible", f"--plugin={plugin}"]
    tiny = ["--n=4", "--budget-ms=0", "--repeats=2", f"--time-limit={TIME_LIMIT_S}"]
    with limited_when_stuck(tmp_path):
        command = ["run", *options, *tiny, f"--out={tmp_path / 'out'}"]
        result = CliRunner().invoke(cli, command, standalone_mode=False)
    assert result.return_value == 0, result.output  # a failure is a row, not a wrong answer
    rows = [c for c in read(tmp_path / "out").cells if c.key.method == "loops"]
    cells = {(c.key.demands, c.key.repeat): c for c in rows}
    assert "no answer" in cells["infeasible", 0].reason
    assert "not tried" in cells["infeasible", 1].reason
    assert cells["inactive", 0].status == cells["inactive", 1].status == "ok"


def test_a_time_limit_ends_a_process_by_the_clock(tmp_path: Path) -> None:
    (tmp_path / "hangs.py").write_text("while True: pass")
    job = Job(method="hangs", plugin=str(tmp_path / "hangs.py"), tasks=[DescribeTask()])
    assert list(work(job, 0.2))[-1] == Failed(0, "timeout", "no answer within 0.2 s")
