"""The table of demands in a row and limits that move: what stands in it, and that a run makes it."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from bench.__main__ import cli
from bench.report.sections.losses import sequences, title
from bench.results.rows import read_run

METHODS = ("pinv", "clip", "nullspace", "qp/daqp")


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    """A tiny run within limits that move, and its folder; without pictures, which take half its time."""
    folder = tmp_path_factory.mktemp("moving")
    sets = ("--demands=slew", "--demands=jolts", "--demands=active")
    tiny = ("--vehicle=ukwial", "--n=30", "--budget-ms=1", "--repeats=1", *(f"--method={m}" for m in METHODS))
    out = folder / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bench.report.draw_all", lambda *_: frozenset())
        return CliRunner().invoke(cli, ["run", *sets, *tiny, f"--out={out}"], standalone_mode=False), out


def test_every_answer_within_limits_of_its_own_is_good(ran: tuple[Result, Path]) -> None:
    result, folder = ran
    assert result.return_value == 0, result.output
    assert all(row.agrees != "no" and not row.wrong for row in read_run(folder).rows)


def test_the_sets_that_move_or_follow_each_other_have_a_table_each(ran: tuple[Result, Path]) -> None:
    run = read_run(ran[1])
    assert {problem.demands: problem.moving for problem in sequences(run)} == {"slew": True, "jolts": True}
    for problem in sequences(run):
        assert title(problem) in (ran[1] / "details.md").read_text()
        assert title(problem) in ran[0].output


def test_every_start_of_a_solver_is_measured_where_demands_follow_each_other(
    ran: tuple[Result, Path],
) -> None:
    rows = [row for row in read_run(ran[1]).rows if row.demands == "slew" and row.method == "qp/daqp"]
    assert {row.start for row in rows} == {"cold", "reused", "warm"}
    lines = [line for line in ran[0].output.splitlines() if line.startswith("| qp/daqp ")]
    cold, warm = lines[0].split("|")[3:5]
    assert float(cold) > 0
    assert float(warm) > 0


def test_losses_are_those_within_the_limits_of_each_call(ran: tuple[Result, Path]) -> None:
    by_method = {row.method: row for row in read_run(ran[1]).rows if row.demands == "jolts"}
    assert by_method["pinv"].limits_violated_share == 1.0
    assert by_method["clip"].limits_violated_share == 0.0
    assert by_method["nullspace"].within_1pct_share > by_method["clip"].within_1pct_share
