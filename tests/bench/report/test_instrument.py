"""report.html in a real browser: what ``thrustbench size`` prints, at a desk, on a phone, on paper."""

import csv
import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from msgspec.structs import replace

from bench.__main__ import cli
from bench.chips.processors import processor
from bench.record import Batch, Cell, Emulated, Judged, Key, Line, Method, Problem, Worker
from bench.report import together
from bench.report.html import data, html
from bench.report.page import page as page_of
from bench.results.machines import read_machines
from tests import made_up
from tests.browsers import browser

ODD = """<script>document.title="taken"</script> "50 %" & |"""
"""A vehicle's name that a careless page would run, or cut short."""
LOOPS = ((100, 10), (400, 5), (1000, 20), (10, 1), (50, 1), (1000, 1))
SETS = ("active", "inactive", "infeasible")
METHODS = {
    "closed": ("unlimited", "-", None),
    "bounded": ("hard", "-", 9),
    "qp/fast": ("hard", "warm", None),
    "qp/fast2": ("hard", "reused", None),
    "qp/slow": ("hard", "cold", None),
    "rule": ("clip", "-", None),
}
"""Formulation, start and steps of methods on every set, each six times as slow as the one before."""
CLOSE = {"near": 12, "nearer": 10}
"""CPU times [us] of two methods that count as equal: the slower one is first, for its steps are bounded."""
ONCE = {"qp/late": ("hard", "reused", None), "long": ("hard", "-", 10_000), "noop": ("", "-", None)}
ONCE |= {"near": ("hard", "-", 9), "nearer": ("hard", "-", None)}
"""Methods on one set: one that is late rather often for the machine's doing, one whose steps may be late."""
PAUSES = (0, 2, 1, 0, 2, 0)
"""Number of calls of each method on each set that the machine held up."""


def lines(seed: int, slower: float) -> list[Line]:
    """A record of two vehicles whose calls take a random time, some of them with pauses of milliseconds."""
    rng = np.random.default_rng(seed)
    made: list[Line] = [made_up.header(machine={"name": f"board {seed}", "cores": 2})]
    made += [Method(name="noop", yardstick=True), Method(name="qp/fast", solver="fast", formulation="hard")]
    for vehicle in ("ukwial", ODD):
        for demands in SETS:
            given = (vehicle, demands) == ("ukwial", "infeasible")  # as if a user had brought this one
            made.append(replace(problem(vehicle, demands), given=given))
            made.append(cell(rng, vehicle, demands, "noop", 0.05 * slower, pauses=3))
            for i, (method, (_, start, _)) in enumerate(METHODS.items()):
                own = cell(rng, vehicle, demands, method, slower * 0.3 * 6.0**i, start, PAUSES[i])
                if given and method == "bounded" and own.judged:
                    own.judged.loss["answered_share"], own.judged.refused_longest = 0.9, 3
                made.append(own)
        late = cell(rng, vehicle, "active", "qp/late", 0.5 * slower, "reused", 10, 3 * 10**5, 30_000)
        made += [late, cell(rng, vehicle, "active", "long", 20.0 * slower, pauses=1, calls=5000)]
        made.append(cell(rng, vehicle, "active", "qp/slow", 200.0, "warm", pauses=0))
        for method, us in CLOSE.items():
            near = cell(rng, vehicle, "active", method, us, calls=5000)
            made.append(replace(near, batches=[Batch(100, 100_000 * us, 100_000 * us, 0)]))
    gone = Cell(Key("ukwial", "active", "gone"), "crashed", reason="signal 11, <b>bold</b>")
    off = made_up.cell("off", key=Key("ukwial", "active", "off"))
    off.judged = Judged(answers=1, counts={"SOLVED": 1}, wrong="limit violated", agrees=False)
    made += [
        gone,
        off,
        Worker(method="rule", start="-", level="-", repeat=0, peak_rss_bytes=9**8),
    ]
    return made


def cell(
    rng: np.random.Generator,
    vehicle: str,
    demands: str,
    method: str,
    median_us: float,
    start: str = "-",
    pauses: int = 0,
    longest_ns: int = 10**7,
    calls: int = 0,
) -> Cell:
    """Some thousand calls spread around a median, and pauses of up to ten milliseconds."""
    calls = calls or (1000 if start == "warm" else int(rng.integers(2500, 7000)))
    formulation, _, steps = (METHODS | ONCE)[method]
    times = (1000 * median_us * rng.lognormal(0.0, 0.3, calls)).round(-1).astype(int) + 10
    singles = dict(zip(*(values.tolist() for values in np.unique(times, return_counts=True)), strict=True))
    for ns in rng.integers(10**5, longest_ns, pauses).tolist():
        singles[ns] = 1
    exact = formulation == "hard"
    share = 0.0 if exact else float(rng.random())
    judged = Judged(
        answers=10,
        counts={"SOLVED": 10},
        agrees=True,
        distance_rel_max=1e-12,
        tolerance=1e-9,
        missed_max=share,
        loss={
            "answered_share": 1.0,
            "lost_wrench_max": share,
            "lost_wrench_p50": share,
            "within_1pct_share": 1.0 - share,
        },
    )
    return Cell(
        Key(vehicle, demands, method, start),
        "ok",
        formulation=formulation,
        batches=[Batch(100, round(100_000 * median_us), round(rng.uniform(2e4, 1e5) * median_us), 0)],
        singles=sorted(singles.items()),
        worst_case_steps=steps,
        judged=judged if formulation else None,
    )


def problem(vehicle: str, demands: str) -> Problem:
    """A set of ten demands, of which all or none can be met."""
    made = made_up.problem(vehicle)
    made.demands, made.labels = demands, {"infeasible" if demands == "infeasible" else "active": 10}
    return made


def kernel(method: str, instructions: int) -> Emulated:
    """Generated C that was counted on an emulated Cortex-M7."""
    return Emulated(
        vehicle="ukwial", target="cortex-m7", method=method, scalar="double", demands="active",
        instructions=[(instructions, 10)], agrees=True,
    )  # fmt: skip


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The folders of two machines that were timed, and of a processor that was emulated."""
    folder = tmp_path_factory.mktemp("runs")
    written = {"one": lines(1, 1.0), "two": lines(2, 9.0)}
    written["counted"] = [
        *(made_up.header(), processor("cortex-m7").facts),
        *(kernel("nullspace@native", 150), kernel("pinv@native", 40)),
    ]
    for name, record in written.items():
        (folder / name).mkdir()
        made_up.record(folder / name, *record)
    return [folder / name for name in written]


@pytest.fixture(scope="module")
def opened(runs: list[Path]) -> Iterator[Any]:
    """A page of the browser with a list of what went wrong in it."""
    with browser() as chromium:
        context = chromium.new_context(viewport={"width": 1280, "height": 900})
        page = context.new_page()
        page.wrong = []
        page.on("console", lambda said: page.wrong.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: page.wrong.append(str(error)))
        page.on("dialog", lambda dialog: page.wrong.append("a dialog"))
        page.on("request", lambda asked: page.wrong.append(asked.url) if asked.url[:5] != "file:" else None)
        yield page
        assert page.wrong == []


def test_of_all_kinds_what_is_lost_is_of_wrenches_that_can_be_met(tmp_path: Path) -> None:
    """As the terminal's *misses*; of one set, such as a log, it is of all its wrenches."""
    loss = {"answered_share": 1.0, "lost_wrench_max": 0.4}
    cell = made_up.cell("scaled", judged=Judged(answers=9, counts={}, loss=loss, missed_max=0.0))
    (machine,) = data(read_machines([made_up.record(tmp_path, made_up.header(), cell)]))["machines"]
    ((every, one),) = [method["pools"] for method in machine["methods"]]
    assert (every["lost"], one["lost"]) == (0.0, 0.4)


def test_of_counts_and_times_together_each_demand_set_has_an_answer(runs: list[Path]) -> None:
    """Whichever folder is named first."""
    for folders in ((runs[2], runs[0]), (runs[0], runs[2])):
        *_, together = data(read_machines(folders))["answers"]
        assert set(together) == {"", *SETS}


def test_a_run_without_methods_has_a_page(tmp_path: Path, opened: Any) -> None:
    open_report(opened, made_up.record(tmp_path, made_up.header()))
    assert opened.inner_text("#verdict").endswith("nothing was measured.")


def test_what_is_not_installed_has_no_kind_of_answers_to_choose(tmp_path: Path) -> None:
    """The list had an entry without a name, which chose all."""
    gone = Cell(Key("ukwial", "active", "gone"), "missing", reason="not installed")
    shown = data(read_machines([made_up.record(tmp_path, made_up.header(), made_up.cell("scaled"), gone)]))
    assert "" in {method["formulation"] for method in shown["machines"][0]["methods"]}
    assert "" not in shown["formulations"]


def open_report(page: Any, *folders: Path, choice: str = "") -> None:
    """Open the runs' report, made unless that was done, and wait for its pictures."""
    out = folders[0].parent / "-".join(folder.name for folder in folders)
    out = folders[0] if len(folders) == 1 else out
    if not (out / "report.html").exists():
        out.mkdir(exist_ok=True)
        machines = read_machines(folders)
        words = page_of(machines[0].run, frozenset()) if len(machines) == 1 else together.page(machines)
        (out / "report.html").write_text(html(machines, words, ""), encoding="utf-8")
    page.goto("about:blank")
    page.goto(f"{(out / 'report.html').as_uri()}#{choice}")
    page.wait_for_function("document.body.dataset.drawn")


def printed(*arguments: str) -> str:
    """Output of ``thrustbench size``."""
    done = CliRunner().invoke(cli, ["size", *arguments])
    assert done.exit_code == 0, done.output
    return done.output


def tables(markdown: str) -> list[list[list[str]]]:
    """The tables of a Markdown text: rows of cells, headings first."""
    found: list[list[list[str]]] = [[]]
    for line in markdown.splitlines():
        if line.startswith("|"):
            found[-1].append(
                [part.strip().replace("\\|", "|") for part in re.split(r"(?<!\\)\|", line)[1:-1]]
            )
        elif found[-1]:
            found.append([])
    return [[rows[0], *rows[2:]] for rows in found if rows]


def shown(page: Any, table: str = "table") -> list[list[str]]:
    """A table of the page, headings first."""
    script = "t => [...t.rows].map(r => [...r.cells].map(c => c.textContent))"
    found: list[list[str]] = page.eval_on_selector(f"#{table}", script)
    return found


def column(rows: list[list[str]], name: str) -> list[str]:
    """The cells below a heading."""
    return [row[rows[0].index(name)] for row in rows[1:]]


@pytest.mark.parametrize(
    ("rate", "budget", "demands"),
    [
        pytest.param(*loop, demands, marks=pytest.mark.long if i else ())
        for demands in ("", "active")
        for i, loop in enumerate(LOOPS)
    ],
)
def test_the_page_says_of_every_method_what_size_prints(
    runs: list[Path], opened: Any, rate: int, budget: int, demands: str
) -> None:
    """Verdict, reason, order and each number, looked up for the loop that was asked."""
    choice = f"vehicle=ukwial&rate={rate:g}&budget={budget:g}&every=1&demands={demands}"
    open_report(opened, runs[0], choice=choice)
    asked = [str(runs[0]), "--rate", str(rate), "--budget", str(budget), "--vehicle", "ukwial"]
    asked += ["--demands", demands] if demands else []
    text = printed(*asked, "--all")
    (expected,) = tables(text)
    ours = shown(opened)
    for name in expected[0]:
        assert column(ours, name) == column(expected, name), name
    assert opened.inner_text("#verdict") == printed(*asked).splitlines()[0]
    unknown = [line[2:] for line in text.splitlines() if line.startswith("- ")]
    assert opened.locator("#unknown li").all_text_contents() == unknown


def test_lates_are_excused_in_some_of_these_rows_and_not_in_others(runs: list[Path]) -> None:
    """Else the test above would not look up where the most verdicts are."""
    asked = [str(runs[0]), "--vehicle", "ukwial", "--all"]
    texts = [printed(*asked, "--rate", str(r), "--budget", str(b)) for r, b in LOOPS]
    reasons = {reason for text in texts for reason in column(tables(text)[0], "why")}
    assert {
        "its steps are bounded, so the machine was late",
        "fixed work was late as often, so the machine was",
    } <= reasons
    assert {"slowest call", "p99.9", "median", "too few calls", ""} <= reasons


@pytest.mark.parametrize(("rate", "budget"), [LOOPS[0], pytest.param(*LOOPS[1], marks=pytest.mark.long)])
def test_on_several_machines_the_page_ranks_as_size_does(
    runs: list[Path], opened: Any, rate: int, budget: int
) -> None:
    """Methods that fit on both machines, and on each."""
    open_report(opened, *runs[:2], choice=f"vehicle=ukwial&rate={rate:g}&budget={budget:g}")
    text = printed(*map(str, runs[:2]), "--rate", str(rate), "--budget", str(budget), "--vehicle", "ukwial")
    expected = tables(text)[0]
    ours = shown(opened)
    for name in ("method", "verdict", "exact"):
        assert column(ours, name) == column(expected, name), name
    for i in (0, 1):
        assert column(ours, f"board {i + 1}") == column(expected, f"board {i + 1}: verdict")
    assert opened.inner_text("#verdict") == text.splitlines()[0]


def test_on_several_machines_the_page_says_how_many_methods_not_all_of_them_measured(
    tmp_path: Path, opened: Any
) -> None:
    for name, methods in (("a", ("m",)), ("b", ("m", "mine", "other"))):
        (tmp_path / name).mkdir()
        cells = [made_up.exact_cell("ukwial", method, 1.0) for method in methods]
        made_up.record(tmp_path / name, made_up.header(), made_up.problem("ukwial"), *cells)
    for choice, said in (("", "2 methods are left out, not measured on every machine"), ("machine=1", "")):
        open_report(opened, tmp_path / "a", tmp_path / "b", choice=choice)
        text = opened.text_content("#in-part")
        assert text.startswith(said)
        assert bool(text) == bool(said)


def test_an_emulated_processor_is_sized_at_the_clock_that_is_chosen(runs: list[Path], opened: Any) -> None:
    """150 instructions of at most 4 cycles at 48 MHz take 12.5 µs: 1 % of 2.5 ms is more, 1 % of 1 ms not."""
    for rate, verdict in ((100, "fits"), (400, "fits"), (1000, "may fit")):
        open_report(opened, *runs, choice=f"vehicle=ukwial&rate={rate}&budget=1&clock=48&machine=2")
        first = dict(zip(*shown(opened)[:2], strict=True))
        assert (first["method"], first["verdict"]) == ("nullspace@native", verdict)
        assert first["exact"] == "yes"
    asked = ["--rate", "1000", "--budget", "1", "--clock", "48", "--machine", "cortex-m7 (emulated)"]
    text = printed(*map(str, runs), *asked)
    assert column(tables(text)[0], "verdict") == column(shown(opened), "verdict") == ["may fit", "fits"]
    assert opened.inner_text("#verdict") == text.splitlines()[0]


def test_beside_a_log_whose_limits_are_half_a_cycle_an_emulated_processor_is_sized(
    tmp_path: Path, opened: Any
) -> None:
    """At 256 Hz 1 % are 6562.5 cycles of 168 MHz, which Python and JavaScript round to different sides."""
    log = replace(made_up.problem("ukwial"), given=True, rate_hz=256.0)
    made = made_up.exact_cell("ukwial", "bounded", 1.0), kernel("nullspace@native", 150)
    folder = made_up.record(tmp_path, made_up.header(), processor("cortex-m7").facts, log, *made)
    open_report(opened, folder, choice="vehicle=ukwial&rate=256&budget=1&clock=168&machine=1")
    assert shown(opened)[1][:2] == ["nullspace@native", "fits"]


def test_a_loop_that_is_not_offered_is_read_as_the_nearest(runs: list[Path], opened: Any) -> None:
    """A link of before may have any; the page says which one it shows."""
    open_report(opened, runs[0], choice="vehicle=ukwial&rate=250&budget=1e9")
    assert opened.inner_text("#verdict").startswith("ukwial at 200 Hz: ")
    assert "20.0 % of the period" in opened.inner_text("#asked")
    open_report(opened, runs[0], choice="vehicle=ukwial&rate=x")
    assert opened.inner_text("#verdict").startswith("ukwial at 100 Hz: ")


def test_two_choices_and_one_look_answer_which_method_fits(runs: list[Path], opened: Any) -> None:
    """The vehicle and the rate chosen, the sentence names the method at once."""
    open_report(opened, runs[0])
    opened.select_option("#vehicle", ODD)
    opened.select_option("#rate", "400")
    first = dict(zip(*shown(opened)[:2], strict=True))
    assert (first["verdict"], first["exact"]) == ("fits", "yes")
    assert opened.inner_text("#verdict").startswith(f"{ODD} at 400 Hz: take {first['method']}; exact.")
    times = opened.evaluate(
        """[100, 200, 400, 10, 1000].map(rate => { const choice = document.getElementById("rate");
        const start = performance.now(); choice.value = rate; choice.dispatchEvent(new Event("change"));
        return performance.now() - start; })"""
    )
    assert min(times) < 100  # ms; the least, for the machine may pause in any
    assert "1000 Hz" in opened.inner_text("#verdict")


def test_the_table_is_sorted_filtered_and_copied_as_it_is_shown(runs: list[Path], opened: Any) -> None:
    open_report(opened, runs[0], choice="vehicle=ukwial")
    opened.click("#table thead >> text=median")
    medians = [float(text) for text in column(shown(opened), "median [%] ▲") if text]
    assert len(medians) > 4
    assert medians == sorted(medians)
    opened.click("#table thead >> text=median")
    assert [float(text) for text in column(shown(opened), "median [%] ▼") if text] == medians[::-1]
    opened.fill("#filter", "qp/fast")
    assert set(column(shown(opened), "method")) == {"qp/fast warm", "qp/fast2 reused"}
    opened.context.grant_permissions(["clipboard-read", "clipboard-write"])
    opened.click("#copy")
    opened.wait_for_function("document.getElementById('copied').textContent")
    copied = list(csv.reader(io.StringIO(opened.evaluate("navigator.clipboard.readText()"))))
    assert [row[0] for row in copied[1:]] == column(shown(opened), "method")
    assert copied[0][:2] == ["method", "verdict"]


def test_a_link_shows_what_was_seen(runs: list[Path], opened: Any) -> None:
    open_report(opened, runs[0])
    opened.select_option("#vehicle", ODD)
    opened.select_option("#rate", "200")
    opened.select_option("#budget", "5")
    opened.check("#exact")
    opened.click("#table tbody button >> nth=1")
    link, seen = opened.url, (shown(opened), shown(opened, "facts"), opened.inner_text("#verdict"))
    opened.goto("about:blank")
    opened.goto(link)
    opened.wait_for_function("document.body.dataset.drawn")
    assert (shown(opened), shown(opened, "facts"), opened.inner_text("#verdict")) == seen


def test_methods_that_are_chosen_stand_side_by_side_with_their_tails(runs: list[Path], opened: Any) -> None:
    open_report(opened, runs[0], choice="vehicle=ukwial")
    for name in ("rule", "bounded"):
        opened.click(f"#table tbody button:text-is('{name}')")
    facts = shown(opened, "facts")
    assert facts[0][1:] == ["rule", "bounded"]
    assert ["worst case [steps]", "not known", "9"] in facts
    opened.wait_for_function("document.querySelector('#tails svg').textContent.includes('bounded')")


def test_beside_what_to_take_stands_the_closed_form_without_limits(tmp_path: Path, opened: Any) -> None:
    """The first method that is not exact did: a rule within limits, where its C was faster than pinv."""
    cells = [
        made_up.exact_cell("ukwial", "bounded", 2.0),
        replace(made_up.exact_cell("ukwial", "rule", 0.1), formulation="clip"),
        replace(made_up.exact_cell("ukwial", "closed", 1.0), formulation="unlimited"),
    ]
    folder = tmp_path / "rules"
    folder.mkdir()
    open_report(opened, made_up.record(folder, made_up.header(), made_up.problem("ukwial"), *cells))
    assert shown(opened, "facts")[0][1:] == ["bounded", "closed"]


def test_hovering_shows_the_numbers_with_their_intervals(runs: list[Path], opened: Any) -> None:
    open_report(opened, runs[0], choice="vehicle=ukwial")
    opened.locator("#cost path[aria-roledescription=point]").first.hover()
    tooltip = opened.locator("#vg-tooltip-element")
    tooltip.wait_for(state="visible")
    assert re.search(r"median\s*\S+ µs \(\S+ … \S+\)", tooltip.inner_text())


def test_everything_is_reached_by_keyboard(runs: list[Path], opened: Any) -> None:
    open_report(opened, runs[0], choice="vehicle=ukwial&rate=100")
    opened.focus("#rate")
    opened.keyboard.press("ArrowDown")
    assert opened.input_value("#rate") == "200"
    opened.focus("#table thead button >> nth=0")
    opened.keyboard.press("Enter")
    names = column(shown(opened), "method ▲")
    assert names == sorted(names)
    opened.keyboard.press("Enter")  # the heading keeps the focus
    assert column(shown(opened), "method ▼") == names[::-1]
    opened.focus("#table tbody button >> nth=0")
    opened.keyboard.press("Space")
    assert shown(opened, "facts")[0][1:] == [names[-1]]


def test_a_table_is_whole_at_a_desk_and_on_a_phone_where_nothing_is_wider_than_the_screen(
    runs: list[Path], opened: Any
) -> None:
    beyond = """[...document.querySelectorAll("table")].filter(table =>
        table.getBoundingClientRect().right > innerWidth || table.scrollWidth > table.clientWidth
        || table.parentElement.scrollWidth > table.parentElement.clientWidth)
        .map(table => table.rows[0].innerText)"""
    try:
        opened.set_viewport_size({"width": 1400, "height": 900})
        open_report(opened, runs[0], choice="vehicle=ukwial")
        assert opened.evaluate(beyond) == []
        opened.set_viewport_size({"width": 390, "height": 844})
        for shown_runs in (runs[:1], runs):
            open_report(opened, *shown_runs)
            opened.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
            assert opened.evaluate(beyond) == []
            assert opened.evaluate("document.documentElement.scrollWidth") == 390
            box = opened.locator("#verdict").bounding_box()
            assert box["y"] + box["height"] < 844  # the sentence stands on the first screen
        label = "getComputedStyle(document.querySelector('#table td:nth-child(2)'), '::before').content"
        assert "verdict" in opened.evaluate(label)
    finally:
        opened.set_viewport_size({"width": 1280, "height": 900})


def test_legends_name_what_is_drawn_and_a_heading_has_something_under_it(
    runs: list[Path], opened: Any
) -> None:
    open_report(opened, runs[0], choice="vehicle=ukwial")
    families = set(filter(None, column(shown(opened), "kind")))
    legend = opened.locator("#cost .role-legend-label text").all_text_contents()
    assert set(legend) <= families
    open_report(opened, runs[2], choice="vehicle=ukwial")
    assert opened.is_visible("#cost svg")
    for heading in ("Time against loss", "Share of calls that took at least so long"):
        assert not opened.is_visible(f"text={heading}")


def test_on_paper_there_are_no_controls_and_in_the_dark_no_white_page(runs: list[Path], opened: Any) -> None:
    open_report(opened, runs[0])
    opened.emulate_media(media="print")
    assert not opened.is_visible("form.choices")
    assert opened.is_visible("#verdict")
    assert opened.pdf(format="A4")[:4] == b"%PDF"
    opened.emulate_media(media="screen", color_scheme="dark")
    assert opened.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(13, 17, 23)"
    opened.emulate_media(color_scheme="light")


def test_names_and_reasons_stand_as_they_are_called(runs: list[Path], opened: Any) -> None:
    open_report(opened, runs[0], choice="vehicle=ukwial")
    assert f"{ODD} (frd)" in opened.locator("#vehicle option").all_text_contents()
    assert "in frd: x ahead, y to starboard, z down" in opened.inner_text("#asked")
    assert (
        "gone: active: crashed, signal 11, <b>bold</b>" in opened.locator("#unknown li").all_text_contents()
    )
    assert opened.title() == "What thrust allocation costs, and what it buys"
