"""Methods worth considering: what their answers are, in words, and what they serve."""

from io import StringIO
from pathlib import Path

import pytest
from msgspec.structs import replace
from rich.console import Console

from bench.record import Capability, Judged, Line, Method
from bench.report.sections import facts
from bench.report.sections.headline import answers, candidates, exact_row
from bench.report.terminal import _verdict, objections, show
from bench.results.columns import Row
from bench.results.ranking import has_wrong_answer, served_share
from bench.results.rows import Run, read_run
from tests import made_up


def run_of(directory: Path, *lines: Line) -> Run:
    return made_up.run(directory, made_up.problem("ukwial"), *lines)


def capability(**shares: int) -> Capability:
    """Number of a hundred demands that each method serves."""
    return made_up.capability(served=[made_up.served(name, share) for name, share in shares.items()])


@pytest.mark.parametrize(
    ("method", "shares", "share"),
    [
        ("scaled@native", {"scaled": 100}, 1.0),  # nullspace was not in the run
        ("qp/any", {"nullspace": 100}, 1.0),
        ("mine", {"mine": 98}, 0.98),
        ("mine", {"other": 98}, None),
        ("mine", {"nullspace": 100}, None),  # exact on a mild log, and too slow to be counted
        ("mine", {"nullspace": 100, "mine": 42}, 0.42),
    ],
)
def test_what_a_method_serves_is_known_wherever_it_was_counted(
    method: str, shares: dict[str, int], share: float | None, tmp_path: Path
) -> None:
    twin, plugin = "scaled" if "@" in method else "", method == "mine"
    described = Method(name=method, formulation="hard", twin=twin, plugin=plugin)
    run = run_of(tmp_path, described, made_up.exact_cell("ukwial", method, 1.0), capability(**shares))
    assert served_share(run, "ukwial", run.rows[0]) == share


def test_a_method_that_misses_what_can_be_met_is_not_near_an_optimum(tmp_path: Path) -> None:
    """A plug-in that says so of itself, and serves nothing, was."""

    def row(counts: dict[str, int], distance: float | None) -> Row:
        cell = made_up.exact_cell("ukwial", "mine", 1.0)
        judged = Judged(answers=10, counts=counts, agrees=True, distance_rel_max=distance)
        (found,) = run_of(tmp_path, replace(cell, judged=judged)).rows
        return found

    assert answers(row({"SOLVED": 10}, 1e-9)) == "the optimum, eq. 4-5"
    assert answers(row({"SOLVED": 10}, 1e-4)) == "near the optimum, eq. 4-5"
    for counts, distance in (({"SOLVED": 4, "PARTIAL": 6}, 1e-9), ({"NOT_CONVERGED": 10}, None)):
        assert answers(row(counts, distance)) == "aims at the optimum, eq. 4-5, misses some that can be met"


def test_a_family_of_an_older_record_has_its_present_name(tmp_path: Path) -> None:
    text = (
        made_up.record(tmp_path, made_up.header(), Method(name="m", family="QP solver, live"))
    ) / "record.jsonl"
    text.write_text(text.read_text().replace("QP solver, live", "exact closed form"))
    (method,) = read_run(tmp_path).record.methods
    assert method.family == "for an optimum, no QP solver"


@pytest.mark.parametrize("plugin", [True, False])
def test_a_plug_in_that_is_wrong_on_another_set_is_wrong_in_the_table(tmp_path: Path, plugin: bool) -> None:
    """The terminal said so, and report.md had "the optimum" of it, by the set that the table is about.

    Starts and levels of a solver are held to promises of their own.
    """
    cell = made_up.exact_cell("ukwial", "mine", 1.0)
    far = replace(cell.judged, agrees=False, distance_rel_max=0.05)
    on_inactive = replace(made_up.rename(cell, demands="inactive"), judged=far)
    run = run_of(tmp_path, Method(name="mine", formulation="hard", plugin=plugin), cell, on_inactive)
    active = next(row for row in run.rows if row.demands == "active")
    assert answers(active).startswith("wrong: farther from the optimum") == plugin
    assert (exact_row([active]) is None) == plugin
    assert [row.demands for row in run.rows if has_wrong_answer(row)] == ["inactive"]
    assert [line.count("inactive demands: 0.05 of") for line in objections(run.rows)] == [1]


def test_a_plug_in_that_is_too_far_off_on_two_sets_is_so_in_each_row_of_its_own(tmp_path: Path) -> None:
    """Each row named the last set, as if its own were right."""
    cell = made_up.exact_cell("ukwial", "mine", 1.0)
    far = made_up.judge(cell, agrees=False, distance_rel_max=0.05)
    on_inactive = made_up.rename(far, demands="inactive")
    rows = run_of(tmp_path, Method(name="mine", formulation="hard", plugin=True), far, on_inactive).rows
    assert {row.wrong for row in rows} == {"farther from the optimum than promised"}
    assert _verdict(list(rows)) == "no, 2x"  # once each, and not as wrong beside it


@pytest.mark.parametrize("plugin", [True, False])
def test_why_a_plug_in_was_not_asked_is_on_the_terminal_too(tmp_path: Path, plugin: bool) -> None:
    """It had "1 refused" there, and the remedy stood in report.md alone."""
    gone = made_up.cell("mine", status="refused", reason="add f_min and f_max", batches=[], judged=None)
    method = Method(name="mine", plugin=plugin)
    made_up.record(tmp_path, made_up.header(), method, made_up.problem("ukwial"), replace(gone, singles=[]))
    output = StringIO()
    show(tmp_path, Console(file=output, width=200))
    assert ("mine on ukwial, inactive demands: refused: add f_min and f_max" in output.getvalue()) == plugin


def test_what_is_wrong_beside_a_set_that_is_refused_is_said_in_its_row(tmp_path: Path) -> None:
    """A plug-in without limits of the call passed those of the vehicle, and report.md said "refused"."""
    gone = made_up.cell(
        "mine", status="refused", reason="takes no limits", batches=[], singles=[], judged=None
    )
    wrong = replace(capability(mine=90), wrong={"mine": "drawn evenly: a limit is violated"})
    key = replace(gone.key, vehicle="ukwial", demands="active")
    run = run_of(tmp_path, Method(name="mine", plugin=True), replace(gone, key=key), wrong)
    assert "refused: takes no limits; wrong: drawn evenly: a limit is violated" in candidates(
        run, frozenset()
    )
    assert "a limit is violated" in facts.agreement(run, frozenset())
