"""Pictures of a run: how many of its methods they show, and what the line without limits stands at."""

from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib.figure import Figure
from msgspec.structs import replace

from bench.record import Cell, Judged, Key, Line, Method
from bench.report.pictures.methods import MOST, MOST_CURVES, cost, overview, pareto, period, tails
from bench.report.pictures.style import SETTINGS, share_axis
from bench.report.sections import cost as times
from bench.report.sections import facts
from bench.report.terminal import miss_text
from bench.results.rows import Run
from tests import made_up

KINDS = {draw.__name__: (draw, MOST) for draw in (cost, pareto, period)} | {"tails": (tails, MOST_CURVES)}


def asked(name: str, us: float, demands: str = "active", loss: float = 0.1, **judged: float) -> Cell:
    """A closed form on a set, with what it loses of any of its wrenches at worst."""
    losses = {"answered_share": 1.0, "lost_wrench_max": loss}
    return made_up.cell(
        key=Key("ukwial", demands, name),
        formulation="unlimited",
        singles=[(round(us * 1000), 10_000)],
        judged=Judged(answers=10, counts={"SOLVED": 10}, agrees=True, loss=losses, **judged),
    )


def run_of(directory: Path, *lines: Line) -> Run:
    return made_up.run(directory, made_up.problem("ukwial"), *lines)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("over", [0, 5])
def test_a_picture_that_has_not_all_methods_says_how_many_and_has_the_user_s_own(
    kind: str, over: int, tmp_path: Path
) -> None:
    """Red before: it stopped at twelve and at ten, and said nothing."""
    draw, most = KINDS[kind]
    n = most + over
    cells = [asked(f"m{i:02}", 1.0 + i) for i in range(n - 1)] + [asked("mine", 99.0)]
    run = run_of(tmp_path, Method(name="mine", family="yours", plugin=True), *cells)
    with mpl.rc_context(SETTINGS):
        figure = draw(run, "ukwial")
    assert figure is not None
    (axes,) = figure.axes
    title = axes.get_title("left")
    assert title.endswith(f": {n - over} of {n} methods") == bool(over)
    assert ("methods" in title) == bool(over)
    assert "mine" in words(figure)
    drawn = frozenset(f"{name}-ukwial.svg" for name in KINDS)
    for text in (times.cost(run, drawn), times.tails(run, drawn), facts.method(run, drawn)):
        assert "each method" not in text  # as "Pictures show each method's …"
        assert "fastest methods" not in text


def words(figure: Figure) -> str:
    return " ".join(text.get_text() for text in figure.findobj(mpl.text.Text))


def test_what_leaving_limits_out_costs_is_of_demands_that_can_be_met_as_on_the_terminal(
    tmp_path: Path,
) -> None:
    """Red before: the line stood at what nobody delivers of a log that asks too much."""
    log = replace(made_up.problem("ukwial"), demands="hot", labels={"infeasible": 5}, given=True)
    cells = [asked("pinv", 1.0, missed_max=0.07), asked("pinv", 1.0, "hot", loss=0.48, missed_max=0.05)]
    run = run_of(tmp_path, log, *cells)
    with mpl.rc_context(SETTINGS):
        figure = overview(run)
    assert figure is not None
    _, right = figure.axes
    (line,) = right.get_lines()
    assert line.get_xdata()[0] == pytest.approx(7.0)
    assert miss_text(list(run.rows)) == f"{line.get_xdata()[0]:g}%"
    assert "that can be met (line)" in right.get_xlabel()


@pytest.mark.parametrize(("missed", "ends"), [(0.07, [100, 100]), (3.5, [350, 400])])
def test_a_share_that_is_missing_is_drawn_also_where_it_is_more_than_all(
    missed: float, ends: list[float], tmp_path: Path
) -> None:
    with mpl.rc_context(SETTINGS):
        figure = overview(run_of(tmp_path, asked("pinv", 1.0, missed_max=missed)))
    assert figure is not None
    assert ends[0] <= figure.axes[1].get_xlim()[1] <= ends[1]


@pytest.mark.parametrize(("named", "halves"), [(["nullspace", "pinv"], 2), (["nullspace"], 1)])
def test_what_leaving_limits_out_costs_has_axes_where_a_method_without_was_asked(
    named: list[str], halves: int, tmp_path: Path
) -> None:
    exact = Judged(answers=10, counts={"SOLVED": 10}, agrees=True, distance_rel_max=1e-9)
    cells = {
        "pinv": asked("pinv", 1.0),
        "nullspace": replace(asked("nullspace", 1.0), formulation="hard", judged=exact),
    }
    run = run_of(tmp_path, *(cells[name] for name in named))
    with mpl.rc_context(SETTINGS):
        figure = overview(run)
    assert figure is not None
    assert len(figure.axes) == halves


@pytest.mark.parametrize(("low", "high"), [(0.48, 1.0), (0.15, 0.8), (1e-6, 1.0)])
def test_an_axis_of_shares_has_two_numbers_to_read_others_by(low: float, high: float) -> None:
    with mpl.rc_context(SETTINGS):
        axes = Figure().add_subplot(yscale="log", ylim=(low, high))
        share_axis(axes.yaxis, "lost")
        numbered = [at for at in axes.yaxis.get_majorticklocs() if low <= at <= high]
    assert len(numbered) >= 2
