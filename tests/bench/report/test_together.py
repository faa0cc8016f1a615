"""The report of several machines: which methods and demand sets have a row there, and what is left out."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from bench.record import Cell, Key, Line, Method
from bench.report import together
from bench.report.sections import headline
from bench.report.sizes import page as sizes_page
from bench.report.verdict import USUAL
from bench.results.machines import NamedRun, count_partial_methods, sizes_on_all
from bench.results.rows import read_run
from bench.results.sizing import sizes
from tests import made_up
from tests.bench.report.test_several_logs import run_of

MANY = 14


def exact(method: str, us: float, demands: str = "active") -> Cell:
    return replace(made_up.exact_cell("ukwial", method, us), key=Key("ukwial", demands, method))


def run(directory: Path, name: str, *lines: Line, **header: object) -> NamedRun:
    directory.mkdir()
    own = made_up.header(machine={"name": name}, **header)
    made = made_up.record(directory, own, made_up.problem("ukwial"), *lines)
    return NamedRun(name, read_run(made))


def rows(text: str) -> list[str]:
    """First column of all tables."""
    return [line.split("|")[1].strip() for line in text.splitlines() if line.startswith("|")]


@pytest.fixture
def many(tmp_path: Path) -> NamedRun:
    """A run of more methods than fit on a page; the user's own is the slowest, and another one crashed."""
    cells = [exact(f"m{i:02}", 1.0 + i) for i in range(MANY)]
    own = [Method(name=name, formulation="hard", plugin=True) for name in ("mine", "gone")]
    crashed = Cell(Key("ukwial", "active", "gone"), "crashed", reason="signal 11")
    return run(tmp_path / "many", "one", *own, *cells, exact("mine", 99.0), crashed)


def test_what_has_a_row_in_the_report_of_a_run_has_one_beside_other_machines(
    many: NamedRun, tmp_path: Path
) -> None:
    other = run(tmp_path / "other", "two", exact("m00", 2.0))
    pages = together.page([many, other])
    alone = rows(headline.candidates(many.run, frozenset()))
    assert {"mine", "gone", "m00"} <= set(alone)
    assert set(alone) <= set(rows(pages))
    assert "| gone" in pages
    assert "crashed: signal 11" in pages


@pytest.mark.parametrize("given", [True, False])
def test_what_a_median_is_on_a_log_is_said_where_there_is_one(given: bool, tmp_path: Path) -> None:
    """Half of a log's calls may take a third of it: a batch has calm demands and saturated ones."""
    problem = replace(made_up.problem("ukwial"), given=given)
    made = made_up.record(tmp_path, made_up.header(), problem, exact("m00", 2.0))
    assert ("near their mean" in headline.candidates(read_run(made), frozenset())) == given


def test_a_plug_in_with_another_text_is_said_by_the_report_and_by_size(tmp_path: Path) -> None:
    """Its times on two machines are those of two methods; ``size`` took the slower one for both."""
    runs = [
        run(tmp_path / name, name, exact("m00", 2.0), files={"casc.py": text})
        for name, text in (("one", "1"), ("two", "2"))
    ]
    sized = {machine.name: sizes(machine.run, USUAL) for machine in runs}
    for text in (together.page(runs), sizes_page(runs, sized, USUAL)):
        assert "one and two: the text of casc.py." in text
    assert "else differs" not in sizes_page(runs[:1], {"one": sized["one"]}, USUAL)


def test_what_is_to_be_taken_on_all_machines_has_a_row_though_others_are_faster(tmp_path: Path) -> None:
    """It is neither the fastest on one machine nor on the front of time and loss."""
    cells = [exact(f"m{i:02}", 1.0 + i) for i in range(MANY)]
    both = [run(tmp_path / "a", "one", *cells), run(tmp_path / "b", "two", exact("m11", 30.0))]
    pages = together.page(both)
    assert "take m11" in pages
    assert "m11" in rows(pages)


def test_a_table_that_stops_says_how_many_methods_it_leaves_out(many: NamedRun) -> None:
    for text in (
        headline.candidates(many.run, frozenset()),
        together.page([many, NamedRun("two", many.run)]),
    ):
        hidden = {f"m{i:02}" for i in range(MANY)} - set(rows(text))
        assert f"Not shown: {len(hidden)} methods, in `details.md`." in text
    details = together.details([many, NamedRun("two", many.run)])
    assert "Not shown" not in details
    assert {f"m{i:02}" for i in range(MANY)} | {"mine", "gone"} <= set(rows(details))


@pytest.mark.parametrize("order", [1, -1])
def test_every_set_that_any_run_was_asked_has_its_table(order: int, tmp_path: Path) -> None:
    both = [
        NamedRun("board", run_of(tmp_path / "board", "active", "mission", given=False)),
        NamedRun("desk", run_of(tmp_path / "desk", "b_hard")),
    ][::order]
    report, details = together.page(both), together.details(both)
    for machine in both:
        for name in machine.run.leading_sets("ukwial"):
            assert f"## ukwial, medians on {name} demands" in report
        for name in machine.run.sets("ukwial"):
            assert f"## ukwial, medians on {name} demands" in details
    assert report.count("Not asked on board.") == report.count("Not asked on desk.") == 1
    assert "pinv" in rows(report.partition("medians on b_hard demands")[2])


def test_methods_that_not_every_machine_measured_are_counted(many: NamedRun, tmp_path: Path) -> None:
    other = run(tmp_path / "other", "two", exact("m00", 2.0))
    sized = {machine.name: sizes(machine.run, USUAL) for machine in (many, other)}
    everyone = {size.method for own in sized.values() for size in own}
    left_out = len(everyone) - len({size.method for size in sizes_on_all(sized, USUAL)})
    assert count_partial_methods(sized) == {"ukwial": left_out}
    said = f"- ukwial: {left_out} methods without a verdict, not measured on every machine."
    assert said in together.page([many, other])
    assert "without a verdict" not in together.page([many, NamedRun("two", many.run)])
