"""A report of several logs that a user brought: each has its place, whatever its name."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from bench.record import Cell, Judged, Key, Line, Method, Problem
from bench.report import together
from bench.report.page import page
from bench.report.sections import cost, headline, losses
from bench.results.machines import NamedRun
from bench.results.rows import Run, read_run
from tests import made_up

LOST = {"easy": 0.0, "hard": 0.6}
"""Share of each log that the rule of practice loses, as f = T* τ does."""


def asked(name: str, *, given: bool = True) -> Problem:
    label = "infeasible" if "hard" in name else "active"
    return replace(made_up.problem("ukwial"), demands=name, labels={label: 10}, given=given)


def cell(method: str, formulation: str, name: str, loss: float) -> Cell:
    """Ten answers on a log that lose this share, and turn by as many degrees as they lose per cent."""
    losses = {f"lost_wrench_{q}": loss for q in ("p50", "p99", "max")}
    losses |= {"answered_share": 1.0, "direction_error_max_deg": 100 * loss}
    return made_up.cell(
        key=Key("ukwial", name, method),
        formulation=formulation,
        judged=Judged(answers=10, counts={"SOLVED": 10}, agrees=True, loss=losses, distance_rel_max=0.0),
    )


def run_of(directory: Path, *names: str, given: bool = True) -> Run:
    """A run on logs of these names; those with "hard" in them are lost to 60 %."""
    directory.mkdir()
    lines: list[Line] = [Method(name="clip@native", twin="clip", foreign=True)]
    for name in names:
        loss = LOST["hard" if "hard" in name else "easy"]
        lines += [asked(name, given=given), cell("pinv", "unlimited", name, loss)]
        lines += [cell("clip@native", "limited", name, loss), cell("clip", "limited", name, loss)]
    return made_up.run(directory, *lines)


@pytest.mark.parametrize("names", [("a_easy", "b_hard"), ("0_hard", "a_easy"), ("active", "b_hard")])
def test_what_is_lost_is_said_of_the_worst_log_whichever_name_comes_first(
    names: tuple[str, ...], tmp_path: Path
) -> None:
    text = headline.headline(run_of(tmp_path / "run", *names), frozenset())
    assert "misses up to 60.0 % of the wrench and points up to 60.0° away" in text


def test_how_logs_were_understood_is_on_the_page_that_is_handed_on(tmp_path: Path) -> None:
    """The terminal alone said it, and a fleet nothing."""
    said = ["log.csv: surge from 'fx'", "log.csv: 2 rows *twice*"]
    problems = [replace(asked(name), said=said) for name in ("a_easy", "b_hard")]
    record = made_up.record(tmp_path, made_up.header(), *problems, cell("pinv", "unlimited", "a_easy", 0.0))
    text = page(read_run(record), frozenset())
    listed = "\n\n- log.csv: surge from 'fx'\n- log.csv: 2 rows \\*twice\\*\n\n"
    assert text.count(f"How the logs were understood:{listed}") == 1
    assert "understood" not in page(run_of(tmp_path / "run", "active", given=False), frozenset())


def test_each_log_has_a_table_of_methods_of_tails_and_of_machines(tmp_path: Path) -> None:
    run = run_of(tmp_path / "run", "a_easy", "b_hard")
    for name in ("a_easy", "b_hard"):
        assert f"### ukwial, {name} demands" in headline.candidates(run, frozenset())
        assert f"### ukwial, {name}\n" in cost.tails(run, frozenset())
        pages = together.page([NamedRun("one", run), NamedRun("two", run)])
        assert f"## ukwial, medians on {name} demands" in pages


def test_what_turns_and_goes_beyond_limits_is_the_worst_of_the_logs(tmp_path: Path) -> None:
    text = losses.losses(run_of(tmp_path / "run", "a_easy", "b_hard"), frozenset())
    assert "a_easy and b_hard: turn [°]" in text
    (line,) = [line for line in text.splitlines() if line.startswith("| clip")]
    assert [each.strip() for each in line.split("|")[3:6]] == ["0 %, 0 %", "60.0 %, 60.0 %", "60.0"]


def test_on_board_logs_of_one_kind_stand_together_with_the_worst(tmp_path: Path) -> None:
    text = cost.onboard(run_of(tmp_path / "run", "a_hard", "b_easy", "c_easy"), frozenset())
    assert "attainable: b_easy and c_easy, not attainable: a_hard" in text


def test_of_sets_that_were_drawn_the_first_stands_for_all(tmp_path: Path) -> None:
    run = run_of(tmp_path / "run", "a_easy", "b_hard", given=False)
    assert run.leading_sets("ukwial") == ["a_easy"]
    assert "misses up to" not in headline.headline(run, frozenset())
