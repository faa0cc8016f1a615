"""A plug-in that crashes or hangs when it is imported costs its own rows; one in ``many`` only, its share."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from alloc.c import missing
from alloc.errors import UnknownName
from bench.__main__ import cli
from bench.harness.plan import RunSettings
from bench.harness.process import DescribeTask, Failed, Job, work
from bench.record import Record, read
from tests.plugin_files import STUCK, limited_when_stuck
from tests.runs import contenders

TIME_LIMIT_S = 0.2
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
    folder = tmp_path_factory.mktemp("imports")
    for name, text in (IMPORTS | MANY).items():
        (folder / f"{name}.py").write_text(text)
    plugins = [f"--plugin={folder / name}.py" for name in IMPORTS | MANY]
    options = ["--vehicle=ukwial", "--demands=inactive", "--method=pinv", "--n=4", "--budget-ms=0"]
    tiny = ["--repeats=1", f"--time-limit={TIME_LIMIT_S}", f"--out={folder / 'out'}"]
    with limited_when_stuck(folder):
        result = CliRunner().invoke(cli, ["run", *plugins, *options, *tiny], standalone_mode=False)
    return result, read(folder / "out")


def test_a_run_with_plug_ins_that_cannot_be_imported_goes_on_to_its_end(
    outcome: tuple[Result, Record],
) -> None:
    result, record = outcome
    assert result.exception is None
    assert result.return_value == 0  # a failure is a row, not a wrong answer
    assert record.events[-1].what == "finished"
    (pinv,) = [cell for cell in record.cells if cell.key.method == "pinv"]
    assert pinv.status == "ok", pinv.reason


@pytest.mark.parametrize(
    ("method", "status", "reason"),
    [
        ("segfaults-at-once", "crashed", "SIGSEGV"),
        ("hangs-at-once", "timeout", f"no answer within {TIME_LIMIT_S:g} s"),
        ("ends-at-once", "crashed", "exit code 0"),
    ],
)
def test_an_import_that_goes_wrong_is_the_reason_of_the_plug_in_s_rows_and_of_its_missing_share(
    outcome: tuple[Result, Record], method: str, status: str, reason: str
) -> None:
    (cell,) = [cell for cell in outcome[1].cells if cell.key.method == method]
    (unserved,) = [u for u in outcome[1].capabilities[0].unserved if u.method == method]
    for row in (cell, unserved):
        assert row.status == status
        assert reason in row.reason


def test_a_time_limit_ends_a_process_by_the_clock(tmp_path: Path) -> None:
    (tmp_path / "hangs.py").write_text("while True: pass")
    job = Job(method="hangs", plugin=str(tmp_path / "hangs.py"), tasks=[DescribeTask()])
    assert list(work(job, 0.2))[-1] == Failed(0, "timeout", "no answer within 0.2 s")


@pytest.mark.parametrize(
    ("method", "status", "reason"),
    [
        ("segfaults-in-many", "crashed", "SIGSEGV"),
        ("drops-a-thruster-in-many", "failed", "thrusts of shape (2000, 3)"),
        ("drops-a-demand-in-many", "failed", "thrusts of shape (1999, 4)"),
    ],
)
def test_a_method_that_goes_wrong_in_many_only_is_measured_and_its_share_is_missing_with_the_reason(
    outcome: tuple[Result, Record], method: str, status: str, reason: str
) -> None:
    (cell,) = [cell for cell in outcome[1].cells if cell.key.method == method]
    assert cell.status == "ok", cell.reason
    (unserved,) = [u for u in outcome[1].capabilities[0].unserved if u.method == method]
    assert unserved.status == status
    assert reason in unserved.reason


def test_a_plug_in_s_own_many_is_asked_for_its_share(outcome: tuple[Result, Record]) -> None:
    shares = {s.method: s.within_1pct for s in outcome[1].capabilities[0].served if s.fault is None}
    assert shares["has-many-of-pinv"] == shares["pinv"]


needs_compiler = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


@pytest.mark.parametrize(
    ("file", "methods"),
    [
        ("noop.py", ()),
        pytest.param("pinv.py", ("pinv@native",), marks=needs_compiler),
        ("nullspace.py", ("qp/daqp",)),
    ],
)
def test_a_plug_in_named_as_a_yardstick_or_as_what_represents_another_method_is_refused(
    tmp_path: Path, file: str, methods: tuple[str, ...]
) -> None:
    path = tmp_path / file
    path.write_text("from alloc.methods.pinv import FORMULATION, build\n")
    with pytest.raises(UnknownName, match="another method is called"):
        contenders(RunSettings(demands=(), methods=methods, plugins=(str(path),)))
