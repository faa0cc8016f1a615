"""The first table: what each method costs as C, and what it delivers of demands that can be met or not."""

from pathlib import Path

from msgspec.structs import replace

from bench.record import Batch, Cell, Judged, Key, Line, Method
from bench.report import render
from bench.report.sections.cost import onboard as section
from bench.results.rows import read_run
from tests import made_up
from tests.browsers import browser

FORMULATIONS = {"nullspace": "hard", "clip": "limited", "shrink": "limited"}
DEMANDS = [
    made_up.problem("ukwial"),
    replace(made_up.problem("ukwial"), demands="infeasible", labels={"infeasible": 10}),
    replace(made_up.problem("ukwial"), demands="dive", labels={"active": 7, "infeasible": 3}),
]


def asked(
    twin: str, demands: str, us: float, *, half: float = 0.0, most: float = 0.0, turn: float = 0.0
) -> Cell:
    """A cell of the twin's C that loses so much of half of its demands and at most, and turns by ``turn``."""
    ns = round(us * 1000)
    loss = {
        "answered_share": 1.0,
        "lost_wrench_p50": half,
        "lost_wrench_p99": most,
        "lost_wrench_max": most,
        "direction_error_max_deg": turn,
    }
    return Cell(
        key=Key("ukwial", demands, f"{twin}@native"),
        status="ok",
        formulation=FORMULATIONS[twin],
        batches=[Batch(100, 100 * ns, 100 * ns, 0)],
        judged=Judged(answers=10, counts={}, agrees=True, loss=loss),
    )


def table(directory: Path, *cells: Cell) -> tuple[list[str], dict[str, list[str]]]:
    """The table's header and its lines by method, of a record of these cells."""
    methods = [Method(name=f"{twin}@native", twin=twin, foreign=True) for twin in FORMULATIONS]
    lines: list[Line] = [*methods, *DEMANDS, *cells]
    text = section(made_up.run(directory, *lines), frozenset())
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line[:1] == "|"]
    return rows[0], {row[0]: row[2:] for row in rows[2:]}


def test_each_kind_of_demand_has_its_price_and_what_is_delivered(tmp_path: Path) -> None:
    cells = [
        asked("clip", "active", 0.1, half=0.04, most=0.2),
        asked("clip", "infeasible", 0.2, half=0.3, most=0.5, turn=20.0),
        asked("clip", "dive", 0.15, half=0.1, most=0.4, turn=10.0),
    ]
    header, lines = table(tmp_path, *cells)
    assert [name for name in header if "[µs]" in name] == [
        "attainable [µs]",
        "not attainable [µs]",
        "some attainable [µs]",
    ]
    met, beyond, mixed = (
        ["0.100", "96.0 %", "80.0 %"],
        ["0.200", "70.0 %", "50.0 %", "20.0"],
        ["0.150", "90.0 %", "60.0 %", "10.0"],
    )
    assert lines == {"clip@native": [*met, *beyond, *mixed, ""]}


def test_a_method_that_delivers_less_than_clip_is_there_with_the_number(tmp_path: Path) -> None:
    cells = [
        asked("clip", "active", 0.1, half=0.04, most=0.2),
        asked("shrink", "active", 0.1, half=0.09, most=0.21),
    ]
    _, lines = table(tmp_path, *cells)
    assert lines["shrink@native"][-1] == "5.00 %"  # in the median: 9 % lost in place of 4 %
    assert lines["clip@native"][-1] == ""


def test_what_is_below_clip_is_the_difference_of_what_both_deliver_and_is_called_so(tmp_path: Path) -> None:
    """The worst demands of the two are not the same one, so no demand need lose so much more."""
    cells = [asked("clip", "active", 0.1, most=0.479), asked("shrink", "active", 0.1, most=0.589)]
    header, lines = table(tmp_path, *cells)
    at = header.index("delivered, all") - 2
    delivered = [float(lines[f"{name}@native"][at].removesuffix(" %")) for name in ("clip", "shrink")]
    below = float(lines["shrink@native"][-1].removesuffix(" %"))
    assert abs(below - (delivered[0] - delivered[1])) < 0.1  # of numbers with three digits
    said = " ".join(section(read_run(tmp_path), frozenset()).split())
    assert "the two worst demands may differ" in said


def test_a_method_that_gives_no_thrusts_beyond_the_limits_refuses(tmp_path: Path) -> None:
    refused = replace(
        asked("nullspace", "infeasible", 0.1),
        judged=Judged(answers=10, counts={"INFEASIBLE": 10}, loss={"answered_share": 0.0}),
    )
    _, lines = table(tmp_path, asked("nullspace", "active", 0.1), refused)
    assert lines["nullspace@native"] == ["0.100", "100 %", "100 %", "0.100", "refused", "", "", ""]


def test_what_is_nearly_met_is_not_said_to_be_met(tmp_path: Path) -> None:
    _, lines = table(tmp_path, asked("shrink", "active", 0.1, most=1e-4))
    assert lines["shrink@native"][:3] == ["0.100", "100 %", "> 99.9 %"]


def test_with_a_log_beside_both_kinds_the_page_shows_the_table_whole(tmp_path: Path) -> None:
    """It was cut at the right, also on a wide screen: 14 columns. A number stays with its unit."""
    cells = [
        asked(twin, each.demands, 0.1, half=0.04, most=0.2, turn=20.0)
        for twin in FORMULATIONS
        for each in DEMANDS
    ]
    header, _ = table(tmp_path, *cells)
    assert len(header) == 14
    page = render(tmp_path).with_suffix(".html")
    with browser() as chromium:
        shown = chromium.new_page(viewport={"width": 1200, "height": 900})
        shown.goto(page.as_uri())
        shown.evaluate("document.getElementById('report').open = true")
        assert shown.evaluate(
            "[...document.querySelectorAll('#report table')].every(one => one.scrollWidth <= one.clientWidth)"
        )
        assert shown.evaluate("document.querySelector('#report td:nth-child(4)').textContent") == "96.0\xa0%"


def test_without_generated_c_there_is_no_table(tmp_path: Path) -> None:
    run = made_up.run(tmp_path, DEMANDS[0], made_up.exact_cell("ukwial", "nullspace", 5))
    assert section(run, frozenset()) == ""


def test_what_a_method_refuses_of_a_log_stands_where_half_of_it_would(tmp_path: Path) -> None:
    """The cell was empty, where 300 of 400 demands got all."""
    dive = asked("nullspace", "dive", 0.1)
    dive = made_up.judge(dive, loss={**dive.judged.loss, "answered_share": 0.7})
    _, lines = table(tmp_path, dive)
    assert lines["nullspace@native"][1:3] == ["refused 30.0 %", "0 %"]


def test_a_log_that_was_not_asked_whole_says_how_much_was(tmp_path: Path) -> None:
    """Its first demands could be met, and others not: the table called the log attainable."""
    first = replace(made_up.problem("ukwial"), demands="mix", n_demands=50, left_out=350, given=True)
    cell = asked("nullspace", "active", 0.1)
    cell = made_up.rename(cell, demands="mix")
    method = Method(name="nullspace@native", twin="nullspace", foreign=True)
    run = made_up.run(tmp_path, method, first, cell)
    assert "attainable: the first 50 of mix." in section(run, frozenset())
