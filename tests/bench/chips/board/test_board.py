"""A log of a board becomes a run like any other, and its report says how a board is timed."""

import re
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from alloc import NotApplicable, load_vehicle
from alloc.formulations import Family
from bench.__main__ import cli
from bench.chips.board.log import boards
from bench.chips.board.project import plan, write
from bench.chips.board.record import keep, lines
from bench.inputs.board_log import LogError, read_board_log
from bench.record import Method, read
from bench.report import render
from bench.report.sections.facts import slowest
from bench.report.verdict import usual_verdicts
from bench.results.machines import read_machines
from bench.results.rows import read_run
from bench.results.size import Fit, Loop
from bench.results.sizing import sizes
from tests.board_logs import forged
from tests.board_projects import METHODS, SETS, make, project


def test_a_log_becomes_a_run_like_any_other(log: bytes, tmp_path: Path) -> None:
    (tmp_path / "LOG").write_bytes(log)
    kept = keep(tmp_path / "LOG", tmp_path / "run", "Desk 1")
    assert kept.good, kept.lines
    (machine,) = read_machines([tmp_path / "run"])
    assert machine.name == "desk-1"
    record = read(tmp_path / "run")
    cells = {(cell.key.method, cell.key.demands): cell for cell in record.cells}
    assert set(cells) == {("noop", "inactive"), *((m, d) for m in METHODS for d in SETS)}
    for (method, demands), cell in cells.items():
        assert sum(times for _, times in cell.singles) == 20 * 150
        assert [batch.calls for batch in cell.batches] == [20] * 150
        if method != "noop":
            (problem,) = [p for p in record.problems if p.demands == demands]
            assert cell.judged is not None
            assert cell.judged.answers == problem.n_demands == 20
            assert len(cell.worst) == 3
    assert cells["nullspace@native", "active"].judged.agrees  # type: ignore[union-attr]
    assert cells["nullspace@native", "infeasible"].judged.counts == {"INFEASIBLE": 20}  # type: ignore[union-attr]
    assert slowest(machine.run, frozenset()).count("nullspace@native") == 3
    sized = sizes(machine.run, Loop(rate_hz=10.0))
    assert {size.method: size.fit for size in sized if size.exact}["nullspace@native"] <= Fit.WITHOUT_TAIL


def test_two_boards_in_one_log_become_two_records(log: bytes, tmp_path: Path) -> None:
    write(project("float"), tmp_path)
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=2")
    second = (tmp_path / "build/posix/LOG").read_bytes()
    (tmp_path / "LOG").write_bytes(log + second)
    keep(tmp_path / "LOG", tmp_path / "runs", "desk")
    first, other = (read(tmp_path / "runs" / name) for name in ("1-desk", "2-desk"))
    assert {sum(times for _, times in cell.singles) for cell in first.cells} == {20 * 150}
    assert {sum(times for _, times in cell.singles) for cell in other.cells} == {20 * 2}


def test_a_board_s_report_says_how_a_board_is_timed_and_nothing_of_python_s_processes(
    log: bytes, tmp_path: Path
) -> None:
    """Nor that the board was quiet, which its driver can't see."""
    (tmp_path / "LOG").write_bytes(log)
    keep(tmp_path / "LOG", tmp_path / "run", "desk")
    render(tmp_path / "run")
    short, long = ((tmp_path / "run" / f"{name}.md").read_text("utf-8") for name in ("report", "details"))
    assert "desk was timed by its driver in double precision, which can't see what else ran there" in short
    assert "generated C from the board's driver." in short
    assert re.search(r"the C's limits +\| +fixed", long)
    assert "One program in C called one method after the other" in long
    for said in ("from Python", "process of its own", "of Python on", "hypervisor", "quiet:", "## Memory"):
        assert said not in short + long, said


def test_a_board_s_report_says_what_did_not_arrive(log: bytes, tmp_path: Path) -> None:
    rows = log.splitlines(keepends=True)
    asked = next(i for i, row in enumerate(rows) if b" ask " in row and b" pinv@native " in row)
    (tmp_path / "LOG").write_bytes(b"".join(rows[: asked + 2] + rows[asked + 3 :]))
    keep(tmp_path / "LOG", tmp_path / "run", "desk")
    render(tmp_path / "run")
    short = (tmp_path / "run/report.md").read_text("utf-8")
    assert "Its log is not whole: left out are pinv@native on " in short


def test_a_solver_s_own_c_on_a_board_is_no_closed_form(log: bytes, tmp_path: Path) -> None:
    """The report said so, and that the solver was called through Python."""
    (tmp_path / "LOG").write_bytes(log)
    (heard,) = boards(tmp_path / "LOG", read_board_log(tmp_path / "LOG"))
    kernels = heard.board.kernels
    kernels["nullspace@native"] = replace(kernels["nullspace@native"], solver="osqp")
    families = {line.name: line.family for line in lines(heard, "desk", "") if isinstance(line, Method)}
    assert families == {"noop": "", "nullspace@native": Family.GENERATED, "pinv@native": ""}


@pytest.mark.parametrize(
    ("ticks", "said"),
    [("return 7;", "stands still"), ("static uint32_t t; return t -= 3;", "goes backwards")],
)
def test_a_port_whose_ticks_are_nonsense_is_told(ticks: str, said: str, tmp_path: Path) -> None:
    write(project(n=3), tmp_path)
    port = tmp_path / "ports/posix.c"
    text = port.read_text()
    begin, end = text.index("    struct timespec"), text.index("}\n\nvoid board_put")
    port.write_text(text[:begin] + f"    {ticks}\n" + text[end:])
    make(tmp_path)
    done = subprocess.run([tmp_path / "build/posix/board"], capture_output=True, timeout=20)
    assert done.returncode == 1
    (tmp_path / "LOG").write_bytes(done.stdout)
    with pytest.raises(LogError, match=said):
        keep(tmp_path / "LOG", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_log_of_demands_keeps_its_rate_and_what_of_it_was_not_asked(tmp_path: Path) -> None:
    """A report opens at the rate of a user's log, and says which share of all of it is refused."""
    rows = "\n".join(f"{i / 20},{tau},0,0" for i, tau in enumerate([100, 900, 900, 900, 100, 100]))
    (tmp_path / "dive.csv").write_text(f"t,surge,sway,yaw\n{rows}\n")
    asked = ["--vehicle", "ukwial", "--method", "nullspace", "--n", "3"]
    words = ["board", *asked, "--demands", str(tmp_path / "dive.csv"), "--out", str(tmp_path)]
    written = CliRunner().invoke(cli, words)
    assert "frame frd (the file names none)" in written.output
    assert "Of dive's 6 demands only the first 3 were asked" in written.output
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    keep(tmp_path / "build/posix/LOG", tmp_path / "run")
    (said,) = usual_verdicts(read_run(tmp_path / "run"))
    assert "at 20 Hz" in said
    assert "refuses 50.0 % of dive's demands, up to 0.15" in said


def test_a_log_with_a_clock_that_says_it_has_none_is_counts_without_the_driver_s_own_method(
    log: bytes, tmp_path: Path
) -> None:
    (tmp_path / "LOG").write_bytes(forged(log, rb"ticks_per_s \d+", b"ticks_per_s 0"))
    keep(tmp_path / "LOG", tmp_path / "out")
    assert {row.method for row in read(tmp_path / "out").emulated} == set(METHODS)


def test_what_a_vehicle_does_not_have_is_left_out_and_said() -> None:
    vehicle = load_vehicle("supply-vessel")
    asked = ("walsh@native", "pinv@native", "clip@library")
    made = plan(vehicle, asked, ("active", "jolts"), "double", "fixed", 5, 0)
    assert [kernel.method for kernel in made.kernels] == ["pinv@native"]
    assert [demands.name for demands in made.sets] == ["active"]
    assert [reason.partition(":")[0] for reason in made.omissions] == [
        "walsh@native",
        "clip@library",
        "jolts",
    ]
    with pytest.raises(NotApplicable, match="supply-vessel: nothing is left to ask"):
        plan(vehicle, ("walsh@native",), ("active",), "double", "fixed", 5, 0)
