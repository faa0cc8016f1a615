"""What to take, in a sentence; how sure that is; one report of several machines."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from msgspec.structs import replace

from bench.__main__ import cli
from bench.record import Cell, Judged, Method, Problem, Quiet
from bench.report.verdict import sure, verdicts
from bench.results.fit import Loop
from bench.results.rows import read_run
from bench.results.sizing import sizes
from tests import made_up
from tests.bench.results.test_sizing import steady

GENERATED = Method(name="nullspace@native", twin="nullspace", formulation="hard", foreign=True)


def said(directory: Path, rate_hz: float, *lines: Cell | Method) -> str:
    """The sentence on the one vehicle of a record."""
    run = read_run(made_up.record(directory, made_up.header(), *lines))
    loop = Loop(rate_hz)
    (sentence,) = verdicts(sizes(run, loop), loop)
    return sentence


def test_the_sentence_names_what_to_take_as_one_says_it_and_what_would_do_too(tmp_path: Path) -> None:
    cells = [
        steady("nullspace@native", 0.5, exact=True),
        steady("nullspace", 5, exact=True),
        steady("qp/daqp", 7, exact=True),
        steady("pinv", 0.1, exact=False),
    ]
    assert said(tmp_path, 100, GENERATED, made_up.solver("qp/daqp"), *cells) == (
        "ukwial at 100 Hz: take nullspace as generated C; exact; under 0.01 % of the period;"
        " qp/daqp would do too."
    )


def test_where_no_exact_method_keeps_up_the_sentence_says_which_is_too_slow(tmp_path: Path) -> None:
    cells = [steady("qp/daqp", 70, exact=True), steady("clip", 2, exact=False)]
    assert said(tmp_path, 10_000, *cells) == (
        "ukwial at 10000 Hz: take clip; not exact (qp/daqp, which is, takes too long); 2.00 % of the period."
    )


def test_where_nothing_fits_the_sentence_says_by_how_much(tmp_path: Path) -> None:
    assert said(tmp_path, 1000, steady("m", 250, exact=True)) == (
        "ukwial at 1000 Hz: nothing here fits 10.0 % of the period;"
        " the fastest median is 25.0 % of the period."
    )


@pytest.mark.parametrize(("steal", "word"), [(0, "quiet: 0 of 2"), (9, "noisy: 2 of 2")])
def test_how_sure_that_is_counts_the_rows_that_the_machine_disturbed(
    steal: int, word: str, tmp_path: Path
) -> None:
    cells = [replace(steady(name, 1, exact=True), quiet=Quiet(steal_ticks=steal)) for name in "ab"]
    run = read_run(made_up.record(tmp_path, made_up.header(), *cells))
    assert sure(run).startswith(f"{word} rows disturbed")


@pytest.fixture
def machines(tmp_path: Path) -> list[Path]:
    """Two machines on which the same was asked: on the second everything takes three times as long."""
    folders = []
    for name, factor in (("fast", 1.0), ("slow", 3.0)):
        problem: Problem = made_up.problem("ukwial")
        cells = [steady("nullspace", 2 * factor, exact=True), steady("clip", factor, exact=False)]
        (tmp_path / name).mkdir()
        header = made_up.header(machine={"name": name})
        folders.append(made_up.record(tmp_path / name, header, problem, *cells))
    return folders


def test_a_report_of_several_machines_has_the_rows_of_all_and_ratios(
    machines: list[Path], tmp_path: Path
) -> None:
    done = CliRunner().invoke(cli, ["report", *map(str, machines), "-o", str(tmp_path / "both")])
    assert done.exit_code == 0, done.output
    text = (tmp_path / "both" / "report.md").read_text(encoding="utf-8")
    assert "- ukwial at 100 Hz on every machine: take nullspace; exact; 0.0600 % of the period." in text
    (line,) = [line for line in text.splitlines() if line.startswith("| nullspace")]
    assert [cell.strip() for cell in line.split("|")[2:5]] == ["2.00", "6.00", "3.00"]
    rows = (tmp_path / "both" / "results.csv").read_text(encoding="utf-8").splitlines()
    place = rows[0].split(",").index("machine")
    assert [row.split(",")[place] for row in rows[1:]] == ["fast", "fast", "slow", "slow"]
    assert not list(machines[0].glob("*.md"))  # what was measured stays as it was


def test_where_not_the_same_was_asked_there_is_no_ratio_but_a_reason(
    machines: list[Path], tmp_path: Path
) -> None:
    cells = [steady("nullspace", 6, exact=True)]
    made_up.record(
        machines[1], made_up.header(machine={"name": "slow"}, seed=7), made_up.problem("ukwial"), *cells
    )
    CliRunner().invoke(cli, ["report", *map(str, machines), "-o", str(tmp_path / "both")])
    text = (tmp_path / "both" / "report.md").read_text(encoding="utf-8")
    (line,) = [line for line in text.splitlines() if line.startswith("| nullspace")]
    assert [cell.strip() for cell in line.split("|")[2:5]] == ["2.00", "6.00", ""]
    assert "No ratio for slow: demands of another seed." in text


def test_several_runs_need_a_folder_for_their_report(machines: list[Path]) -> None:
    done = CliRunner().invoke(cli, ["report", *map(str, machines)])
    assert done.exit_code == 2
    assert "-o OUT" in done.output


def test_a_verdict_opens_what_a_run_and_what_size_print(machines: list[Path]) -> None:
    text = CliRunner().invoke(cli, ["size", *map(str, machines), "--rate", "400", "--budget", "5"]).output
    assert text.startswith("ukwial at 400 Hz on every machine: take nullspace; exact;")
    assert text.splitlines()[2].startswith("fast was quiet")


def test_answers_that_are_wrong_have_no_verdict(tmp_path: Path) -> None:
    judged = Judged(answers=1, counts={"SOLVED": 1}, wrong="limit violated")
    wrong = replace(steady("m", 1, exact=True), judged=judged)
    assert said(tmp_path, 100, wrong).endswith(
        "nothing here fits 10.0 % of the period; none has a time that counts."
    )
