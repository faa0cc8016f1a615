"""A run, end to end, with real worker processes."""

import os
import re
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest
from click.testing import CliRunner
from msgspec.structs import replace
from rich.console import Console

import alloc
from alloc import AllocError, NotApplicable
from alloc.errors import DemandError, UnknownName
from bench.__main__ import cli
from bench.demands import DemandSet
from bench.harness import environment, machine
from bench.harness.lines import header, problem
from bench.harness.plan import RunSettings
from bench.harness.run import check_same, run
from bench.harness.state import Progress
from bench.inputs.faults import GivenFault
from bench.judging.question import ask_here, questions
from bench.record import FILE_NAME, RecordError, read
from bench.report import render
from bench.report.terminal import show
from tests import made_up
from tests.places import ROOT
from tests.runs import contenders, demand_sets

DEMANDS = ["--demands=inactive", "--demands=active", "--demands=infeasible"]
TINY = ["run", "--vehicle=ukwial", "--method=pinv", *DEMANDS, "--n=8", "--budget-ms=1", "--repeats=2"]


def test_a_run_measures_and_judges_every_cell_once_and_writes_a_report_under_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(cli, TINY, standalone_mode=False)
    assert result.return_value == 0, result.output
    (folder,) = (tmp_path / "runs" / machine.name()).iterdir()
    assert (folder / "results.csv").is_file()
    cells = [cell for cell in read(folder).cells if cell.key.method == "pinv"]
    keys = [(cell.key.demands, cell.key.repeat) for cell in cells]
    assert sorted(keys) == [(d, r) for d in ("active", "inactive", "infeasible") for r in (0, 1)]
    for cell in cells:
        assert cell.status == "ok"
        assert cell.judged is not None
        assert cell.judged.agrees is True
        assert cell.judged.wrong == ""
        assert all(batch.calls % cell.n_demands == 0 for batch in cell.batches)


@pytest.mark.parametrize(
    ("option", "names"),
    [
        ("--vehicle=nobody", "nobody"),
        ("--demands=nothing", "nothing"),
        ("--method=qp/zz*", "qp/zz*"),
        ("--plugin=nowhere.py", "nowhere.py"),
        ("--fault=two", "two"),
        ("--fault=9", "9"),
    ],
)
def test_an_unknown_name_is_refused_before_anything_is_written(
    option: str, names: str, tmp_path: Path
) -> None:
    before = (tmp_path / FILE_NAME, b"an older record\n")
    before[0].write_bytes(before[1])
    command = [*TINY, option, f"--out={tmp_path}"]
    error = CliRunner().invoke(cli, command, standalone_mode=False).exception
    assert isinstance(error, AllocError)
    assert names in str(error)
    assert before[0].read_bytes() == before[1]


@pytest.mark.usefixtures("bare_runs")
def test_a_plug_in_on_a_faulty_vehicle_and_a_pattern_of_methods_are_measured(tmp_path: Path) -> None:
    plugin = tmp_path / "my_pinv.py"
    plugin.write_text("from alloc.methods.pinv import FORMULATION, build\n")
    options = ["--vehicle=ukwial", "--fault=1", "--method=pin[v]", f"--plugin={plugin}", "--demands=inactive"]
    tiny = ["--n=4", "--budget-ms=0", "--repeats=1", f"--out={tmp_path / 'out'}"]
    assert CliRunner().invoke(cli, ["run", *options, *tiny], standalone_mode=False).return_value == 0
    measured = {(c.key.method, c.key.vehicle): c.status for c in read(tmp_path / "out").cells}
    assert measured["my-pinv", "ukwial-f1"] == "ok"
    assert measured["pinv", "ukwial-f1"] == "ok"


@pytest.mark.parametrize(("wanted", "others"), [("my-pinv", []), ("*pinv", ["pinv"]), ("pinv", ["pinv"])])
def test_a_plug_in_takes_part_once_whether_it_is_named_or_not(
    wanted: str, others: list[str], tmp_path: Path
) -> None:
    plugin = tmp_path / "my_pinv.py"
    plugin.write_text("from alloc.methods.pinv import FORMULATION, build\n")
    chosen = contenders(RunSettings(demands=(), methods=(wanted,), plugins=(str(plugin),)))
    assert [contender.method.name for contender in chosen] == ["my-pinv", *others]
    with pytest.raises(UnknownName, match="no method 'my_pinv'; did you mean my-pinv or"):
        contenders(RunSettings(demands=(), methods=("my_pinv",), plugins=(str(plugin),)))


@pytest.mark.usefixtures("bare_runs")
def test_the_parent_keeps_off_the_core_that_workers_are_pinned_to(tmp_path: Path) -> None:
    seen = []

    def watch(_: Progress) -> None:
        seen.append(machine.core())

    settings = RunSettings(
        vehicles=("ukwial",), demands=("inactive",), methods=("pinv",), n_demands=4, budget_ms=0, repeats=1
    )
    run(settings, tmp_path, resume=False, watch=watch)
    (core,) = {worker.core for worker in read(tmp_path).workers}
    assert core == machine.core()
    if core is not None and len(os.sched_getaffinity(0)) > 1:
        assert core not in seen


def test_a_worker_finds_a_source_tree_that_nobody_installed_from_any_folder(tmp_path: Path) -> None:
    root = ROOT
    # -S: no site-packages, so that an installed thrustbench can't stand in for the source tree.
    ask = "import importlib.util; print(importlib.util.find_spec('bench').origin)"
    path = {"PYTHONPATH": environment()["PYTHONPATH"].partition(os.pathsep)[0]}
    done = subprocess.run(
        [sys.executable, "-S", "-c", ask], cwd=tmp_path, env=path, capture_output=True, text=True, check=True
    )
    assert Path(done.stdout.strip()) == root / "bench" / "__init__.py"


def sets(names: list[str], demands: list[str], n: int) -> list[DemandSet]:
    settings = RunSettings(vehicles=tuple(names), demands=tuple(demands), n_demands=n)
    return demand_sets(settings)[0]


def test_demands_of_a_log_that_were_not_asked_are_counted_and_reported(tmp_path: Path) -> None:
    log = tmp_path / "dive.csv"
    log.write_text("surge,sway,yaw\n" + "1,0,0\n" * 9)
    for n, left_out in ((4, 5), (9, 0), (60, 0)):
        (question,) = questions(sets(["ukwial"], [str(log)], n), ask_here)
        asked = problem(question)
        assert (asked.n_demands, asked.left_out) == (9 - left_out, left_out)
        directory = made_up.record(tmp_path, made_up.header(), asked, made_up.cell())
        output = StringIO()
        show(directory, Console(file=output))
        details = render(directory).with_name("details.md")
        for text in (output.getvalue(), details.read_text(encoding="utf-8")):
            assert ("Of dive's 9 demands only the first 4 were asked; `--n` asks more." in text) == (n == 4)


def test_demands_that_a_vehicle_has_not_are_left_out_with_the_reason() -> None:
    """With thruster 2 off three are left for three axes: no demand needs more than a closed form."""
    settings = RunSettings(
        vehicles=("ukwial",), demands=("active", "infeasible"), faults=(None, GivenFault(2)), n_demands=5
    )
    made, told = demand_sets(settings)
    assert [(one.vehicle.name, one.name) for one in made] == [
        ("ukwial", "active"),
        ("ukwial", "infeasible"),
        ("ukwial-f2", "infeasible"),
    ]
    (line,) = told
    assert line.startswith("demands left out: active: ukwial-f2: no demand is attainable only by")
    alone = replace(settings, demands=("active",), faults=(GivenFault(2),))
    with pytest.raises(NotApplicable, match="active: ukwial-f2: no demand is attainable only by"):
        demand_sets(alone)


def test_each_vehicle_that_lacks_a_set_has_its_own_reason(tmp_path: Path) -> None:
    """The second one's was the first one's, which was not true of it."""
    mine = tmp_path / "mine.yaml"
    limits = "f_min: -50\nf_max: 60\nvolts: {14: [-20, 25], 16: [-50, 60]}\n"
    mine.write_text(f"name: mine\ndof: [surge]\nframe: frd\nT: [[1, 1]]\n{limits}")
    settings = RunSettings(
        vehicles=("ukwial", "tiburon", str(mine)), demands=("sag", "inactive"), n_demands=5
    )
    _, told = demand_sets(settings)
    assert told == [
        "demands left out: sag: ukwial: has no limits by voltage; add 'volts' to its file; so for 1 more;"
        " mine: its table of volts has 14 to 16 V, not 13 to 16.8 V"
    ]


def test_two_logs_or_vehicles_of_one_name_are_refused_not_dropped(tmp_path: Path) -> None:
    logs = []
    for folder, row in (("monday", "10,0,0"), ("tuesday", "0,10,0")):
        (tmp_path / folder).mkdir()
        logs.append(tmp_path / folder / "dive.csv")
        logs[-1].write_text(f"surge,sway,yaw\n{row}\n")
    with pytest.raises(DemandError, match="'ukwial', 'dive'"):
        sets(["ukwial"], [*map(str, logs)], 5)
    assert len(sets(["ukwial"], [str(logs[0])] * 2, 5)) == 1  # a log named twice is one demand set

    shipped = (Path(alloc.__file__).parent / "vehicles" / "ukwial.yaml").read_text(encoding="utf-8")
    mine = tmp_path / "mine.yaml"
    mine.write_text(shipped.replace("f_max: 250", "f_max: 100"))
    with pytest.raises(DemandError, match="'ukwial', 'active'"):
        sets(["ukwial", str(mine)], ["active"], 5)


@pytest.mark.parametrize(
    ("name", "faults", "reason"),
    [
        ("ukwial-f2", (GivenFault(2),), "two different vehicles are called 'ukwial-f2'"),
        ("-", (None,), "stands for none"),
    ],
)
def test_a_vehicle_named_as_another_after_a_failure_or_as_none_is_refused(
    tmp_path: Path, name: str, faults: tuple[GivenFault | None, ...], reason: str
) -> None:
    shipped = (Path(alloc.__file__).parent / "vehicles" / "ukwial.yaml").read_text(encoding="utf-8")
    mine = tmp_path / "mine.yaml"
    mine.write_text(shipped.replace("name: ukwial", f"name: '{name}'"))
    settings = RunSettings(vehicles=("ukwial", str(mine)), demands=("inactive",), faults=faults)
    with pytest.raises(DemandError, match=reason):
        demand_sets(settings)


@pytest.mark.parametrize("changed", ["mine.py", "mine.yaml", "log.csv", "bag/part.db3"])
def test_a_user_s_file_that_changed_since_keeps_a_record_from_being_continued(
    tmp_path: Path, changed: str
) -> None:
    (tmp_path / "bag").mkdir()
    files = [tmp_path / name for name in ("mine.py", "mine.yaml", "log.csv", "bag/part.db3")]
    for file in files:
        file.write_text("first")
    plugin, vehicle, log, _ = map(str, files)
    demands = (log, str(tmp_path / "bag"), "active")
    settings = RunSettings(demands=demands, vehicles=(vehicle,), plugins=(plugin,))
    before = header(settings)
    check_same(before, header(settings), tmp_path)
    (tmp_path / changed).write_text("second")
    with pytest.raises(
        RecordError, match=f"was made with {re.escape(str(tmp_path / changed.split('/')[0]))}"
    ):
        check_same(before, header(settings), tmp_path)


def test_a_mission_is_judged_whole_however_few_of_its_demands_are_timed(tmp_path: Path) -> None:
    """Red before: 60 demands said "take nullspace", 3,000 "take scaled"; 0 % of them within 1 %, and 86 %."""
    plugin = tmp_path / "late.py"  # its answers are right, but for one demand that is not among the first
    plugin.write_text(LATE, encoding="utf-8")
    found = {}
    for n in (8, 60):
        out = tmp_path / str(n)
        options = [
            f"--vehicle=ukwial|--method=pinv|--demands=mission|--plugin={plugin}|--n={n}|--budget-ms=1"
        ]
        options = [*options[0].split("|"), "--repeats=2", f"--out={out}"]
        CliRunner().invoke(cli, ["run", *options], standalone_mode=False)
        cells = [cell for cell in read(out).cells if cell.key.demands == "mission" and cell.judged]
        assert {cell.n_demands for cell in cells if cell.judged and cell.key.method == "pinv"} == {3000}
        assert all(batch.calls % n == 0 for cell in cells for batch in cell.batches)
        found[n] = [
            (
                cell.key.method,
                cell.judged.answers,
                cell.judged.loss,
                cell.judged.missed_max,
                cell.judged.wrong,
            )
            for cell in cells
            if cell.judged and cell.key.repeat == 0
        ]
        (asked,) = [each for each in read(out).problems if each.demands == "mission"]
        assert (asked.n_demands, asked.left_out, sum(asked.labels.values())) == (3000, 0, 3000)
        assert {c.judged.answers for c in cells if c.judged and c.key.repeat == 1} == {0}
    assert sorted(found[8]) == sorted(found[60])
    assert {method: bool(wrong) for method, *_, wrong in found[8]} == {"pinv": False, "late": True}


LATE = """
import numpy as np
import alloc

FORMULATION = "limited"


def build(vehicle):
    exact, last = alloc.build("clip", vehicle), []

    def allocate(tau, f_min=None, f_max=None):
        last.append(tau[0])
        f = exact(tau).f
        return f + 1e3 * (tau[0] > 100)

    return allocate
"""
