"""report.md and report.html: what they show of a record, and what they refuse."""

import json
import re
import sys
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt

from bench.__main__ import main
from bench.record import Batch, Cell, Emulated, Event, Judged, Key, Line, Loss, Method
from bench.report import render
from bench.report.html import document
from bench.report.page import details, page
from bench.report.sections import cost, emulation, facts, headline
from bench.report.sections.cost import count_disjoint
from bench.results.rows import read_run
from bench.results.text import number_range, plain, table, three
from tests import made_up
from tests.made_up import exact_cell, header, problem, record


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a record of every kind of row, rendered."""
    directory = tmp_path_factory.mktemp("run")
    assert render(made_up.whole(directory)) == directory / "report.md"
    return directory


def detailed(directory: Path) -> str:
    """details.md of the run in a folder, without pictures."""
    return details(read_run(directory), frozenset())


def opening(directory: Path) -> str:
    """report.md of the run in a folder, without pictures."""
    return page(read_run(directory), frozenset())


def test_the_same_record_gives_the_same_bytes(rendered: Path, tmp_path: Path) -> None:
    render(made_up.whole(tmp_path))
    first = {path.name: path.read_bytes() for path in rendered.iterdir()}
    assert first == {path.name: path.read_bytes() for path in tmp_path.iterdir()}


def test_the_report_names_failures_and_wrong_answers_with_their_reasons(rendered: Path) -> None:
    text = (rendered / "details.md").read_text(encoding="utf-8")
    assert "signal 11" in text
    assert "wrench missed by 3 N" in text


def test_the_report_shows_every_picture_in_the_folder_and_no_other(rendered: Path) -> None:
    pages = [(rendered / name).read_text(encoding="utf-8") for name in ("report.md", "details.md")]
    shown = re.findall(r"\]\(([^)]+\.svg)\)", "".join(pages))
    assert sorted(shown) == sorted(path.name for path in rendered.glob("*.svg"))


NAMES = ["Fähre 1", "a)b]", "a/b", '<b>&"c', "50%20"]


@pytest.mark.parametrize(
    "name", ["-".join(NAMES), *(pytest.param(each, marks=pytest.mark.long) for each in NAMES)]
)
def test_a_vehicle_of_any_name_has_its_pictures_in_the_report(name: str, tmp_path: Path) -> None:
    cell = made_up.cell(key=Key(name, "inactive", "pinv"))
    render(made_up.record(tmp_path, made_up.header(), cell))
    pages = "".join((tmp_path / page).read_text(encoding="utf-8") for page in ("report.md", "details.md"))
    shown = {unquote(link) for link in re.findall(r"\]\(([^)]+\.svg)\)", pages)}
    assert len(shown) >= 3
    assert shown == {path.name for path in tmp_path.glob("*.svg")}


def test_the_headline_counts_solvers_that_give_up_although_they_keep_their_promise(tmp_path: Path) -> None:
    def counts(method: str, **statuses: int) -> Cell:
        return msgspec.structs.replace(
            made_up.exact_cell("ukwial", method, 1.0), judged=Judged(answers=10, counts=statuses, agrees=True)
        )

    cells = [counts("qp/a", SOLVED=10), counts("qp/b", SOLVED=8, NOT_CONVERGED=2), counts("qp/c", PARTIAL=10)]
    text = opening(made_up.record(tmp_path, made_up.header(), made_up.problem("ukwial", 4), *cells))
    short = "2 of them of optimising methods that stop short of some demand that can be met"
    assert f"Of 3 rows 3 are right ({short})" in text


def test_the_headline_compares_generated_c_with_c_and_a_solver_s_call_with_its_own_clock(
    tmp_path: Path,
) -> None:
    def without_limits(method: str, us: float) -> Cell:
        return msgspec.structs.replace(made_up.exact_cell("ukwial", method, us), formulation="unlimited")

    solver = msgspec.structs.replace(made_up.exact_cell("ukwial", "qp/daqp", 6.0), solver_singles=[(300, 99)])
    cells = [made_up.solver("qp/daqp"), made_up.exact_cell("ukwial", "nullspace@native", 0.1), solver]
    cells += [without_limits("pinv@native", 0.08), without_limits("pinv", 1.0)]
    text = opening(made_up.record(tmp_path, made_up.header(), *cells))
    assert (
        "That is 1.2 to 1.3 times the time of f = T* τ in generated C. It is 0.1 times the time of f = T* τ"
        " in numpy. f = T* τ knows no limits. The fastest QP solver that is as exact takes 60 times as long,"
        " called through Python (5.00 % of it by its own clock). Ratios are extremes of batches" in text
    )


@pytest.mark.parametrize(
    ("repeats", "ratio"),
    [
        ((1.73, 0.746, 1.75, 1.39), "as fast as f = T* τ in generated C, within noise"),
        ((1.31, 1.27, 1.44, 1.29, 1.3, 1.33), "1.2 to 1.5 times the time of f = T* τ in generated C"),
        ((1.3, 1.3, 1.3, 1.3, 1.3, 1.3, 1.3, 0.6, 1.3), "1.3 times the time of f = T* τ in generated C"),
    ],
)
def test_a_ratio_comes_of_pairs_of_repeats_and_not_of_the_luckiest_binary(
    repeats: tuple[float, ...], ratio: str, tmp_path: Path
) -> None:
    """Exact C that starts from T* τ was "0.600 times the time" of it: the fastest of several binaries."""
    cells = []
    for i, us in enumerate(repeats):
        for method, time in (("nullspace@native", us), ("pinv@native", 1.0), ("scaled@native", 0.6)):
            cell = made_up.rename(made_up.exact_cell("ukwial", method, time), repeat=i)
            formulation = "unlimited" if method == "pinv@native" else "hard"
            cells.append(msgspec.structs.replace(cell, formulation=formulation))
    native = Method(name="nullspace@native", twin="nullspace", formulation="hard")
    text = opening(made_up.record(tmp_path, made_up.header(), native, *cells))
    assert f"). That is {ratio}. f = T* τ knows no limits." in text


def test_the_report_explains_the_formulations_of_its_run_and_no_other_of_the_tree(tmp_path: Path) -> None:
    run = made_up.run(tmp_path, made_up.exact_cell("ukwial", "nullspace", 1.0))
    text = cost.cost(run, frozenset())
    assert "*hard* is the least effort" in text
    assert "*soft*" not in text


@pytest.mark.parametrize(("slower", "apart"), [(1.0, 0), (1.01, 0), (1.1, 1)])
def test_repeats_whose_intervals_of_p99_do_not_meet_are_counted(
    slower: float, apart: int, tmp_path: Path
) -> None:
    # Ten thousand calls take 1.000 to 1.010 µs: the interval is far narrower than a tenth.
    repeats = [
        made_up.cell(
            key=Key("ukwial", "active", "pinv", repeat=i),
            singles=[(round(factor * ns), 1000) for ns in range(1000, 1010)],
        )
        for i, factor in enumerate((1.0, slower))
    ]
    once = made_up.cell(key=Key("ukwial", "inactive", "pinv"))
    run = made_up.run(tmp_path, *repeats, once)
    assert count_disjoint(run.rows) == (apart, 1)
    assert f"in {apart} of 1 rows" in detailed(tmp_path)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (None, ""),
        (0.0, "0"),
        (-0.0, "0"),
        (1.2345, "1.23"),
        (9.999, "10.0"),
        (99.95, "100"),
        (0.012345, "0.0123"),
        (12345.6, "12300"),
        (1.5e-9, "1.50e-9"),
        (2.345e9, "2.34e9"),
        (float("inf"), "inf"),
    ],
)
def test_numbers_have_three_significant_digits(value: float | None, shown: str) -> None:
    assert three(value) == shown


def test_a_range_is_one_number_where_both_ends_show_the_same_and_nothing_where_there_is_none() -> None:
    assert number_range([2.0, None, 1.0]) == "1.00 to 2.00"
    assert number_range([1.001, 1.002], "…") == "1.00"
    assert number_range([None]) == ""


def test_a_table_aligns_numbers_right_and_words_left() -> None:
    text = table(("method", "t [µs]", "why"), [["pinv", "1.00", "yes"], ["svd", "", "no"]])
    ends = [(rule[0], rule[-1]) for rule in text.splitlines()[1].split("|")[1:4]]
    assert ends == [(":", "-"), ("-", ":"), (":", "-")]


def test_the_html_report_has_no_link_to_another_file(rendered: Path) -> None:
    text = (rendered / "report.html").read_text(encoding="utf-8")
    assert "<table>" in text
    markup = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert not re.search(r"(src|href)=|url\(|@import|://", markup)


def test_a_picture_has_a_rule_for_the_dark_page_for_each_of_its_colours(rendered: Path) -> None:
    from bench.report.pictures.style import DARK

    pictures = sorted(rendered.glob("*.svg"))
    assert pictures
    for picture in pictures:
        rules, _, drawn = picture.read_text(encoding="utf-8").partition("</style>")
        styles = " ".join(re.findall(r'style="([^"]*)"', drawn))
        used = set(re.findall(r"(fill|stroke): (#[0-9a-f]{6})", styles))
        assert {colour for _, colour in used} <= set(DARK)
        for what, colour in used:  # only !important overrides a style attribute
            assert f'[style*="{what}: {colour}"]{{{what}:{DARK[colour]}!important}}' in rules


def test_what_to_take_has_a_row_of_the_report_although_another_is_as_good_on_what_was_asked(
    tmp_path: Path,
) -> None:
    """On a log whose first demands can be met ``nullspace`` is faster, and refuses some of the others."""
    asked = msgspec.structs.replace(
        problem("ukwial"), given=True, left_out=90, beyond=30, beyond_longest=30, rate_hz=50.0
    )
    scaled = msgspec.structs.replace(exact_cell("ukwial", "scaled", 2.0), formulation="scaled")
    lines = [
        made_up.judge(made, loss={"lost_wrench_max": 0.0, "answered_share": 1.0})
        for made in (exact_cell("ukwial", "nullspace", 1.0), scaled)
    ]
    text = page(made_up.run(tmp_path, asked, *lines), frozenset())
    assert "take scaled" in text
    assert re.search(r"^\| scaled +\|", text.partition("## Methods worth considering")[2], re.M), text
    assert "Of active's 100 demands only the first 10 were asked" in text


def test_what_is_lost_beyond_what_a_formula_serves_is_said_only_where_it_was_asked(tmp_path: Path) -> None:
    for lost, said in ((1e-15, False), (0.25, True)):
        loss = {"lost_wrench_max": lost, "direction_error_max_deg": 100 * lost}
        judged = Judged(answers=10, counts={"SOLVED": 10}, agrees=True, loss=loss)
        run = made_up.run(tmp_path, problem("ukwial"), made_up.cell("pinv", judged=judged))
        assert ("misses up to" in headline.headline(run, frozenset())) is said


@pytest.mark.parametrize(("beyond", "said"), [(0, ""), (3, ", some of which no thrusts meet,")])
def test_a_loss_on_demands_that_nothing_meets_is_not_laid_to_the_formula_alone(
    beyond: int, said: str, tmp_path: Path
) -> None:
    loss = {"lost_wrench_max": 0.25, "direction_error_max_deg": 9.0}
    cell = made_up.cell("pinv", judged=Judged(answers=10, counts={}, agrees=True, loss=loss))
    labels = {"inactive": 10 - beyond, "infeasible": beyond}
    asked = msgspec.structs.replace(problem("ukwial"), demands=cell.key.demands, labels=labels)
    text = headline.headline(made_up.run(tmp_path, asked, cell), frozenset())
    assert f"On the 10 demands asked{said} f = T* τ misses up to 25.0 %" in text


@pytest.mark.parametrize(
    ("corners", "said"),
    [
        (
            made_up.loss(16, 0.416, turned_max_deg=2.0),
            "At the worst of its corners and of 2,000 demands drawn evenly it misses up to 41.6 % of the"
            " wrench and points up to 16.4° away. Thrusts are cut at the limits; each is exceeded by less"
            " than 0.5 % of all such demands.",
        ),
        (
            None,
            "At the worst of 2,000 demands drawn evenly from that (its corners are too many) it misses up to"
            " 39.4 % of the wrench and points up to 16.4° away",
        ),
    ],
)
def test_the_worst_of_a_closed_form_is_of_corners_and_all_demands_drawn(
    corners: Loss | None, said: str, tmp_path: Path
) -> None:
    """Red before: 25.1 % of the demands timed, where a demand drawn lost 39.4 % and a corner 41.6 %."""
    loss = {"lost_wrench_max": 0.251, "direction_error_max_deg": 12.3}
    cell = made_up.cell("pinv", judged=Judged(answers=10, counts={}, agrees=True, loss=loss))
    sample = made_up.loss(2000, 0.394, turned_max_deg=16.4)
    served = made_up.served("pinv", 1000, 2000, sample=sample, corners=corners)
    lines = [msgspec.structs.replace(problem("ukwial"), demands=cell.key.demands), cell]
    run = made_up.run(tmp_path, *lines, made_up.capability(served=[served]))
    text = headline.headline(run, frozenset())
    assert f"serves 50.0 % of what a vehicle can do: that much is delivered within 1 %. {said}" in text
    given = msgspec.structs.replace(lines[0], given=True)  # a log's own demands are what matters
    run = made_up.run(tmp_path, given, cell, made_up.capability(served=[served]))
    assert "On the 10 demands asked it misses up to" in headline.headline(run, frozenset())


def test_what_the_user_brought_has_a_row_of_the_report_whatever_it_is_worth(tmp_path: Path) -> None:
    """A plug-in that loses in time and wrench, one that is wrong, and one that was not measured."""
    problems = [problem("ukwial")]
    names = ("slow", "off", "gone")
    methods = [Method(name=name, plugin=True) for name in names]
    exact = [exact_cell("ukwial", "nullspace", 1.0), exact_cell("ukwial", "slow", 9.0)]
    off = exact_cell("ukwial", "off", 0.5)
    off = msgspec.structs.replace(
        off, judged=Judged(answers=1, counts={}, wrong="a limit is violated", agrees=True)
    )
    gone = msgspec.structs.replace(
        exact_cell("ukwial", "gone", 1.0),
        status="failed",
        reason="ZeroDivisionError",
        batches=[],
        judged=None,
    )
    run = made_up.run(tmp_path, *problems, *methods, *exact, off, gone)
    text = headline.candidates(run, frozenset())
    for name, says in (
        ("slow", ""),
        ("off", "wrong: a limit is violated"),
        ("gone", "failed: ZeroDivisionError"),
    ):
        assert re.search(rf"^\| {name} +\| {says}", text, re.M), text
    assert "Your own methods are always listed" in text


@pytest.mark.parametrize(
    ("scalars", "shown", "words"), [(("float",), 40, "single"), (("float", "double"), 90, "double")]
)
def test_a_record_of_single_precision_alone_fills_the_table_too(
    scalars: tuple[str, ...], shown: int, words: str, tmp_path: Path
) -> None:
    counts = {"float": 40, "double": 90}
    kernels = [
        Emulated(
            vehicle="ukwial",
            target="cortex-m7",
            method="pinv@native",
            scalar=scalar,
            limits="fixed",
            demands="active",
            instructions=[(counts[scalar], 3)],
            worst=[1.0, 0.0, 0.0],
        )
        for scalar in scalars
    ]
    text = emulation.summary(made_up.run(tmp_path, *kernels))
    assert re.search(rf"^\| ukwial +\| pinv@native +\| fixed +\| +{shown} \|", text, re.M), text
    assert f"took in {words} precision" in text


def test_what_is_not_installed_is_one_line_of_the_details(tmp_path: Path) -> None:
    gone = [
        made_up.cell(
            f"qp/{name}", status="missing", reason=f"pip install {name}", batches=[], singles=[], judged=None
        )
        for name in ("a", "b", "c")
    ]
    text = facts.agreement(made_up.run(tmp_path, *gone), frozenset())
    [line] = [line for line in text.splitlines() if "qp/" in line]
    assert re.match(r"\| qp/a, qp/b, qp/c +\| everywhere +\| missing +\| pip install a; pip install b", line)


def test_a_reason_may_hold_bars_lines_and_tags_without_breaking_a_table(tmp_path: Path) -> None:
    failed = made_up.cell("m", status="failed", reason="a | b\n<script>alert(1)</script>", judged=None)
    render(made_up.record(tmp_path, made_up.header(), failed))
    text = (tmp_path / "details.md").read_text(encoding="utf-8")
    (line,) = [line for line in text.splitlines() if "alert" in line]
    assert line.replace("\\|", "").count("|") == 5
    assert "<script>alert" not in (tmp_path / "report.html").read_text(encoding="utf-8")


HOSTILE = "![x](http://a.example/x.png) [y](http://a.example) <img src=http://a.example> `*b*` _c_ $d$ &amp;"


def prose(markdown: str) -> str:
    made: str = MarkdownIt("commonmark", {"html": False}).enable("table").render(markdown)
    return made


def test_nothing_from_data_is_markdown_or_fetched_by_the_page(tmp_path: Path) -> None:
    """Names of vehicle, set and method, and the reason of a failure; each stands in the page as it is."""
    key = Key(f"v{HOSTILE}", f"d{HOSTILE}", f"m{HOSTILE}")
    failed = made_up.cell("m", status="failed", reason=HOSTILE, judged=None)
    bad = made_up.cell(judged=Judged(answers=1, counts={}, wrong=HOSTILE, agrees=False))
    cells = [msgspec.structs.replace(cell, key=key) for cell in (failed, bad)]
    cells[1].key = msgspec.structs.replace(key, method=f"n{HOSTILE}")
    machine = {"cpu": HOSTILE, "id": HOSTILE}
    run = read_run(record(tmp_path, header(machine=machine, versions={HOSTILE: HOSTILE}), *cells))
    for text in (page(run, frozenset()), details(run, frozenset())):
        shown = prose(text)
        assert not re.findall(r"<(?:img|a) [^>]*>", shown)
        assert f"v{HOSTILE}" in unescape(re.sub(r"<[^>]+>", "", shown))


@given(
    st.text(alphabet="ab 1.*_`[]()<>!#+-~$&;:|\\/=\"'", min_size=1, max_size=14).map(str.strip).filter(bool)
)
def test_plain_text_is_shown_as_it_is_where_a_line_begins_and_in_a_table(text: str) -> None:
    text = " ".join(text.split())
    for made in (prose(f"- {plain(text)}"), prose(table(("a", "b"), [(text, "1")]))):
        shown = unescape(re.sub(r"<[^>]+>", "", made)).split("\n")
        if not re.fullmatch(r"`[^`]+`", text):  # which is this project's own way to write code in a cell
            assert text in shown


def test_the_page_lets_nothing_in_from_outside(rendered: Path) -> None:
    text = (rendered / "report.html").read_text(encoding="utf-8")
    [policy] = re.findall(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', text)
    assert policy.startswith("default-src 'none';")
    assert not re.search(r"https?:|\*", policy)
    assert text.index(policy) < text.index("<style") < text.index("<script")


@pytest.mark.parametrize(
    "name",
    ["$\\frac$", *(pytest.param(each, marks=pytest.mark.long) for each in ("$a$", "a$b$c_{", "${", "$$"))],
)
def test_a_name_may_hold_what_a_drawing_library_takes_for_mathematics(name: str, tmp_path: Path) -> None:
    made = record(
        tmp_path, header(), problem(name), *(exact_cell(name, m, us) for m, us in (("a", 1.0), ("b", 2.0)))
    )
    render(made)
    assert list(tmp_path.glob("*.svg"))


def lossy(method: str, lost: float, beyond: float = 0.0) -> Cell:
    """A cell that loses this share of the wrench at worst, and is beyond limits in that share of answers."""
    loss = {"lost_wrench_p50": 0.0, "lost_wrench_max": lost, "answered_share": 1.0}
    judged = Judged(answers=10, counts={"SOLVED": 10}, loss=loss | {"limits_violated_share": beyond})
    return made_up.cell(method, key=Key("ukwial", "active", method), judged=judged)


def losses_of(directory: Path, *lines: Line) -> str:
    """The section on losses of a record of these lines."""
    text = detailed(made_up.record(directory, made_up.header(), *lines))
    return text.partition("## What you lose")[2].partition("\n## ")[0]


def rows_of(section: str) -> dict[str, list[str]]:
    """Cells of a section's table by their first."""
    lines = [line for line in section.splitlines() if line.startswith("| ")][1:]
    return {cells[0]: cells[1:] for cells in ([part.strip() for part in x.split("|")[1:-1]] for x in lines)}


def test_methods_that_lose_the_same_share_a_line_and_those_that_lose_nothing_a_sentence(
    tmp_path: Path,
) -> None:
    cells = [lossy("pinv", 0.3, 1.0), lossy("svd", 0.3, 1.0), lossy("clip", 0.2), lossy("nullspace", 1e-9)]
    section = losses_of(tmp_path, *cells)
    assert list(rows_of(section)) == ["clip", "nullspace", "pinv, svd"]
    assert "30.0 %" in rows_of(section)["pinv, svd"][1]
    assert "Of all attainable demands above, the only ones asked, nothing is lost by nullspace.\n" in section


def test_what_loses_some_of_what_was_drawn_is_in_no_sentence_that_nothing_is_lost(tmp_path: Path) -> None:
    """Red before: "nothing that is attainable is lost by redistribute", which serves 99.5 % within 1 %."""
    served = [
        made_up.served("nullspace", 2000, 2000, sample=made_up.loss(2000, 1e-9)),
        made_up.served("redistribute", 1990, 2000, sample=made_up.loss(2000, 0.08)),
    ]
    cells = [lossy(name, 0.0) for name in ("nullspace", "redistribute", "qp")]
    lines = [problem("ukwial"), made_up.capability(served=served), *cells]
    section = losses_of(tmp_path, *lines)
    drawn = "Of the 10 attainable demands above and of 2,000 drawn evenly from what ukwial can do"
    part = "They lose part of less than 0.5 % of all such demands."
    assert f"{drawn}, nothing is lost by nullspace. {part}\n" in section
    assert "Of the 10 attainable demands above, the only ones asked, nothing is lost by qp.\n" in section
    assert {name: cells[2] for name, cells in rows_of(section).items()} == {
        "nullspace": "0 %",
        "redistribute": "8.00 %",
        "qp": "not asked",
    }
    older = [msgspec.structs.replace(each, sample=None) for each in served]
    section = losses_of(tmp_path, *lines[:1], made_up.capability(served=older), *cells)
    assert "2,000 drawn evenly from what ukwial can do at most 1 %, by nullspace.\n" in section
    assert "by redistribute" not in section


def test_every_method_that_was_run_has_a_line_with_how_many_it_answered(tmp_path: Path) -> None:
    """Red before: nothing active was asked, and who refuses all that is beyond reach had no line."""
    refusing = made_up.rename(lossy("nullspace", 0.0), demands="infeasible")
    refusing = made_up.judge(refusing, loss={"answered_share": 0.0})
    few = made_up.judge(lossy("qp/qoco", 0.0), loss={"answered_share": 0.3, "lost_wrench_max": 0.0})
    lines = rows_of(
        losses_of(tmp_path, refusing, made_up.rename(lossy("clip", 0.2), demands="infeasible"), few)
    )
    assert {name: cells[0] for name, cells in lines.items()} == {
        "nullspace": "0 of 10",
        "clip": "10 of 10",
        "qp/qoco": "3 of 10",
    }
    assert "none answered" in lines["nullspace"]


def test_agreement_says_of_how_many_answers(tmp_path: Path) -> None:
    """Red before: "1 of 1" of a method that answered 3 of 10."""
    few = made_up.judge(lossy("qp/qoco", 0.0), agrees=True, loss={"answered_share": 0.3})
    text = detailed(made_up.record(tmp_path, made_up.header(), few))
    (cells,) = [line.split("|") for line in text.partition("## Agreement")[2].splitlines() if "qoco" in line][
        :1
    ]
    assert [cells[3].strip(), cells[4].strip()] == ["1 of 1", "3 of 10"]


@pytest.mark.parametrize("answered", [1.0, 0.9])
def test_a_method_that_gives_up_on_what_a_closed_form_serves_has_a_line_of_its_own(
    answered: float, tmp_path: Path
) -> None:
    """The page said that nothing attainable is lost, with 30 % of the easy demands answered."""
    cells = [lossy("clip", 0.2), lossy("qp", 0.0)]
    for cell in cells[:]:
        share = answered if cell.key.method == "qp" else 1.0
        loss = cell.judged.loss | {"lost_wrench_max": 0.0, "answered_share": share}
        judged = msgspec.structs.replace(cell.judged, loss=loss)
        key = msgspec.structs.replace(cell.key, demands="inactive")
        cells.append(msgspec.structs.replace(cell, key=key, judged=judged))
    section = losses_of(tmp_path, *cells)
    assert ("nothing is lost by qp" in section) == (answered == 1)
    assert ("(90.0 % answered)" in section) == ("inactive: lost, worst" in section) == (answered < 1)


def test_a_method_beyond_its_limits_does_not_count_as_losing_nothing(tmp_path: Path) -> None:
    assert "nothing is lost" not in losses_of(tmp_path, lossy("pinv", 0.0, 0.1))


def test_a_run_that_was_stopped_before_its_first_row_still_has_a_report(tmp_path: Path) -> None:
    text = detailed(made_up.record(tmp_path, made_up.header()))
    assert "## The machine" in text
    assert "## What a call costs" not in text


@pytest.mark.parametrize(("last", "stopped"), [("began", True), ("interrupted", True), ("finished", False)])
def test_the_report_of_a_run_that_did_not_end_says_so(tmp_path: Path, last: str, stopped: bool) -> None:
    events = [
        Event(what="began", at="2026-01-01T00:00:00Z"),
        Event(what=last, at="2026-01-01T00:01:00Z", wall_s=60.0, timed_s=40.0),
    ]
    text = opening(made_up.record(tmp_path, made_up.header(), made_up.cell(), *events))
    assert ("stopped before its end" in text) == stopped


def test_the_result_table_goes_between_the_markers_and_nowhere_else(tmp_path: Path) -> None:
    from bench.report.page import END, START, put, result_table

    table_text = result_table(read_run(made_up.whole(tmp_path)))
    readme = tmp_path / "README.md"
    readme.write_text(f"before\n{START}\nold\n{END}\nafter\n")
    put(readme, table_text)
    assert readme.read_text(encoding="utf-8") == f"before\n{START}\n{table_text}{END}\nafter\n"


def test_the_result_table_has_ten_lines_at_most_however_many_methods_lose_less_and_less(
    tmp_path: Path,
) -> None:
    """Twenty methods, each slower than the one before and more exact, are all on the front."""
    from bench.report.page import result_table

    cells = [
        msgspec.structs.replace(lossy(f"m{i}", 0.5**i), batches=[Batch(1, 1000 * (i + 1), 1000 * (i + 1), 0)])
        for i in range(20)
    ]
    text = result_table(made_up.run(tmp_path, *cells))
    assert len([line for line in text.splitlines() if line.startswith("| `")]) == 10


def test_a_file_without_markers_is_left_alone(tmp_path: Path) -> None:
    from bench.report.page import MarkerError, put

    (tmp_path / "README.md").write_text("nothing here\n")
    with pytest.raises(MarkerError, match="results:start"):
        put(tmp_path / "README.md", "table")
    assert (tmp_path / "README.md").read_text() == "nothing here\n"


HEADER = {
    "type": "header",
    "schema": 1,
    "started": "",
    "commit": "",
    "seed": 0,
    "machine": {},
    "versions": {},
}
BAD_RECORDS = {
    "missing folder": None,
    "empty": b"",
    "binary": bytes(range(256)),
    "foreign JSON": b'{"hello": 1}\n',
    "not an object": b"[]\n",
    "other schema": b'{"type": "header", "schema": 99}\n',
    "field missing": json.dumps(HEADER).encode() + b"\n",
}


@pytest.mark.parametrize("command", [["report"], ["size", "--rate", "100"]], ids=lambda words: words[0])
@pytest.mark.parametrize("content", BAD_RECORDS.values(), ids=BAD_RECORDS.keys())
def test_a_folder_without_a_readable_record_ends_with_2_and_one_line(
    tmp_path: Path,
    content: bytes | None,
    command: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    directory = tmp_path / "run"
    if content is not None:
        directory.mkdir()
        (directory / "record.jsonl").write_bytes(content)
    monkeypatch.setattr(sys, "argv", ["thrustbench", command[0], str(directory), *command[1:]])
    with pytest.raises(SystemExit) as ended:
        main()
    message = capsys.readouterr().err
    assert ended.value.code == 2
    assert message.count("\n") == 1
    assert "record.jsonl" in message
    assert not list(tmp_path.rglob("*.md"))


def test_a_run_without_times_has_no_result_table_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made_up.record(tmp_path, made_up.header())
    readme = tmp_path / "README.md"
    readme.write_text("as it was")
    monkeypatch.setattr(sys, "argv", ["thrustbench", "report", str(tmp_path), "--readme", str(readme)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert "no times of any vehicle" in capsys.readouterr().err
    assert readme.read_text(encoding="utf-8") == "as it was"


def test_both_pages_say_in_which_frame_each_vehicle_s_demands_are(tmp_path: Path) -> None:
    """Records from before the frame was kept are in frd, as all vehicles then were."""
    up = msgspec.structs.replace(problem("rov"), frame="flu")
    problems = (up, problem("ukwial"), msgspec.structs.replace(up, demands="box"))
    directory = record(tmp_path, header(), *problems, made_up.cell())
    for text in (opening(directory), detailed(directory)):
        assert "Demands of ukwial are in frd: x ahead, y to starboard, z down." in text
        assert "Demands of rov are in flu: x ahead, y to port, z up." in text
    assert b'"frame":"frd"' not in (tmp_path / "record.jsonl").read_bytes()


def test_a_page_shows_tags_in_its_title_and_text_as_they_are(tmp_path: Path) -> None:
    made = document("# <b>T</b> & {{ x }}\n\n<i>words</i>\n", tmp_path)
    assert "<title>&lt;b&gt;T&lt;/b&gt; &amp; {{ x }}</title>" in made
    assert "<p>&lt;i&gt;words&lt;/i&gt;</p>" in made
