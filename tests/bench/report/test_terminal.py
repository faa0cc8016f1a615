"""The table at the end of a run: what a method costs, which share it serves and what it misses."""

from io import StringIO
from pathlib import Path

import msgspec
from rich.console import Console

from alloc.formulations import Family
from bench.record import Cell, Judged, Key, Method, Unserved
from bench.report.sections import headline
from bench.report.terminal import miss_text, objections, served_shares, show
from bench.results.ranking import served_share
from bench.results.rows import read_run
from tests import made_up
from tests.made_up import cell, exact_cell, header, problem, record


def judged(lost: float, share: float) -> Judged:
    loss = {"lost_wrench_max": lost, "within_1pct_share": share}
    return Judged(answers=10, counts={"SOLVED": 10}, wrench_error_max=[0.0], agrees=True, loss=loss)


def on(demands: str, method: str, lost: float, share: float) -> Cell:
    return msgspec.structs.replace(
        cell(method), key=Key("ukwial", demands, method), judged=judged(lost, share)
    )


CAPABILITY = made_up.capability(
    authority=[],
    served=[
        made_up.served("pinv", 1400, 2000, within_5pct=1600),
        made_up.served("pinv", 200, 2000, within_5pct=400, fault=2),
    ],
)


def test_the_share_served_is_the_whole_vehicle_s_or_that_of_the_uniform_set(tmp_path: Path) -> None:
    cells = [
        on("uniform", "pinv", 0.3, 0.65),
        on("uniform", "qp/x", 1e-9, 1.0),
        on("active", "qp/x", 1e-9, 0.9),
        on("active", "qp/y", 1e-9, 0.9),
    ]
    run = made_up.run(tmp_path, CAPABILITY, *cells)
    by_method = {name: [row for row in run.rows if row.method == name] for name in ("pinv", "qp/x", "qp/y")}
    assert served_shares(run, by_method["pinv"]) == [0.7]
    assert served_shares(run, by_method["qp/x"]) == [1.0]
    assert served_shares(run, by_method["qp/y"]) == []


def test_the_terminal_and_the_report_say_the_same_of_what_is_served(tmp_path: Path) -> None:
    """Red before: a solver that is exact, and C that prepares itself, had no share on the terminal."""
    names = ("nullspace", "scaled@library", "qp/daqp", "pinv", "rule")
    counted = [made_up.served(name, k, 10) for name, k in (("nullspace", 10), ("pinv", 7))]
    cells = [exact_cell("ukwial", name, 1.0) for name in names[:3]]
    cells += [on("active", name, 0.3, 0.1) for name in names[3:]]
    can = msgspec.structs.replace(CAPABILITY, served=counted)
    library = Method(name="scaled@library", twin="scaled", formulation="hard")
    run = made_up.run(tmp_path, problem("ukwial"), library, can, *cells)
    expected = {"nullspace": [1.0], "scaled@library": [1.0], "qp/daqp": [1.0], "pinv": [0.7], "rule": []}
    for row in run.rows:
        share = served_share(run, "ukwial", row)
        assert served_shares(run, [row]) == ([] if share is None else [share]) == expected[row.method]


def test_infeasible_demands_do_not_count_as_missed(tmp_path: Path) -> None:
    cells = [on("active", "clip", 0.25, 0.5), on("infeasible", "clip", 0.5, 0.0), on("box", "clip", 0.6, 0.0)]
    run = made_up.run(tmp_path, *cells)
    assert miss_text(list(run.rows)) == "25%"


def test_a_demand_without_thrusts_loses_its_whole_wrench(tmp_path: Path) -> None:
    loss = {"answered_share": 0.9, "lost_wrench_max": 1e-15, "within_1pct_share": 0.9}
    gave_up = msgspec.structs.replace(
        on("active", "qp/x", 0.0, 0.0),
        judged=Judged(
            answers=10,
            counts={"SOLVED": 9, "NOT_CONVERGED": 1},
            wrench_error_max=[0.0],
            agrees=True,
            loss=loss,
        ),
    )
    run = made_up.run(tmp_path, gave_up)
    assert miss_text(list(run.rows)) == "100%"


def test_a_method_that_failed_on_a_set_is_not_said_to_miss_nothing_of_the_others(tmp_path: Path) -> None:
    """A rule that raised beyond its limits had a 0 % there, of demands within them."""
    failed = msgspec.structs.replace(on("active", "rule", 0.0, 0.0), status="failed", judged=None)
    elsewhere = msgspec.structs.replace(failed, key=Key("other", "active", "rule"))
    inside = on("inactive", "rule", 0.0, 1.0)
    for lines, said in (((inside, failed), ""), ((inside, elsewhere), "0%")):
        folder = tmp_path / f"{len(said)}"
        folder.mkdir()
        assert miss_text(list(made_up.run(folder, *lines).rows)) == said


def test_a_loss_of_rounding_is_shown_as_zero(tmp_path: Path) -> None:
    run = made_up.run(tmp_path, on("active", "nullspace", 1e-15, 1.0))
    assert miss_text(list(run.rows)) == "0%"


def test_the_table_names_its_columns_and_their_units(tmp_path: Path) -> None:
    record(tmp_path, header(), CAPABILITY, on("uniform", "pinv", 0.3, 0.65))
    console = Console(width=100, record=True, file=StringIO())
    assert show(tmp_path, console)
    text = console.export_text()
    for word in ("serves", "70.0%", "misses", "30%", "[us]"):
        assert word in text


def test_a_plug_in_that_fails_after_a_failure_is_said_where_its_share_is_missing(tmp_path: Path) -> None:
    failed = Unserved(method="mine", status="failed", reason="with thruster 2 off: LinAlgError")
    counted = msgspec.structs.replace(CAPABILITY, served=[], unserved=[failed])
    brought = Method(name="mine", formulation="mine", plugin=True)
    record(tmp_path, header(), brought, problem("ukwial"), counted, on("active", "mine", 0.0, 1.0))
    console = Console(width=200, record=True, file=StringIO())
    show(tmp_path, console)
    said = "mine on ukwial, what it serves is not counted: failed with thruster 2 off: LinAlgError"
    assert said in console.export_text().splitlines()
    assert said in headline.candidates(read_run(tmp_path), frozenset())


def test_agreement_of_a_method_that_gives_up_says_how_many_it_answered(tmp_path: Path) -> None:
    """Red before: "yes" of a method that answered 3 of 10 that can be met."""
    few = made_up.judge(exact_cell("ukwial", "qp/x", 1.0), loss={"answered_share": 0.3})
    few = msgspec.structs.replace(few, n_demands=10)
    show(made_up.record(tmp_path, header(), problem("ukwial"), few), console := Console(file=StringIO()))
    assert "yes of 3 of 10 answered" in console.file.getvalue()  # type: ignore[attr-defined]  # a StringIO


def test_a_disagreement_without_a_promise_is_named_too(tmp_path: Path) -> None:
    unpromised = Judged(answers=1, counts={"SOLVED": 1}, agrees=False, distance_rel_max=0.5)
    run = made_up.run(tmp_path, cell(judged=unpromised))
    [line] = objections(run.rows)
    assert line.endswith("0.5 of the largest limit away from the reference, where - is promised")


def test_a_rival_s_broken_promise_is_said_and_spoils_no_run(tmp_path: Path) -> None:
    """A solver's own C stops where its settings say; a binding that this project sets up is held to more."""
    far = Judged(answers=1, counts={"SOLVED": 1}, agrees=False, distance_rel_max=0.12, tolerance=0.1)
    for family, wrong, good in (
        (Family.GENERATED, "", True),
        (Family.GENERATED, "a limit is violated", False),
        (Family.LIVE, "", False),
    ):
        off = cell("qp/x@generated", judged=msgspec.structs.replace(far, wrong=wrong))
        record(tmp_path, header(), Method(name="qp/x@generated", family=family, solver="x"), off)
        console = Console(width=200, record=True, file=StringIO())
        assert show(tmp_path, console) is good
        text = console.export_text()
        assert (wrong or "0.12 of the largest limit away") in text
        assert ("1 wrong" in text) == bool(wrong)


def test_what_is_not_installed_is_one_line_of_a_run_s_end(tmp_path: Path) -> None:
    gone = [
        msgspec.structs.replace(
            cell(f"qp/{name}"), status="missing", reason=f"pip install {name}", batches=[], judged=None
        )
        for name in ("a", "b", "c")
    ]
    record(tmp_path, header(), *gone, cell("pinv"))
    console = Console(width=200, record=True, file=StringIO())
    assert show(tmp_path, console)
    naming = [line for line in console.export_text().splitlines() if "qp/" in line]
    assert naming == ["not installed: qp/a, qp/b, qp/c; `thrustbench list` says how to get them"]


def test_brackets_in_a_name_are_printed_as_they_are(tmp_path: Path) -> None:
    record(tmp_path, header(), on("active", "[bold]", 0.3, 0.65), on("active", "a[/b]", 0.3, 0.65))
    console = Console(width=100, record=True, file=StringIO())
    show(tmp_path, console)
    text = console.export_text()
    assert "[bold]" in text
    assert "a[/b]" in text


def test_the_longest_names_and_numbers_and_a_failure_fit_on_a_line_of_a_terminal(tmp_path: Path) -> None:
    rows = [
        cell("qp/clarabel", us, key=Key("ukwial", demands, "qp/clarabel", "reused", "tight"))
        for us, demands in ((1, "active"), (3333, "inactive"))
    ]
    gone = cell("qp/clarabel", status="crashed", reason="signal 11", batches=[], singles=[], judged=None)
    gone = msgspec.structs.replace(gone, key=Key("ukwial", "uniform", "qp/clarabel", "reused", "tight"))
    record(tmp_path, header(), *rows, gone)
    console = Console(width=80, record=True, file=StringIO())
    show(tmp_path, console)
    [line] = [line for line in console.export_text().splitlines() if "clarabel" in line]
    assert line.startswith("qp/clarabel reused tight")
    assert "1 crashed" in line


def test_no_label_is_cut_short_in_a_file_however_narrow_the_terminal_was(tmp_path: Path) -> None:
    label = "a-method-with-a-name-that-is-rather-long/and-a-solver-with-another"
    record(tmp_path, header(), cell(label, key=Key("ukwial", "active", label, "reused", "tight")))
    text = StringIO()
    show(tmp_path, Console(file=text, width=40))
    assert f"{label} reused tight" in text.getvalue()


def test_a_run_s_end_opens_with_what_to_take_and_lists_the_most_useful_first(tmp_path: Path) -> None:
    cells = [exact_cell("ukwial", "b-exact", 200.0), exact_cell("ukwial", "z-exact", 1.0)]
    cells.append(msgspec.structs.replace(exact_cell("ukwial", "a-rule", 0.1), formulation="clip"))
    record(tmp_path, header(), *cells)
    text = StringIO()
    show(tmp_path, Console(file=text))
    lines = text.getvalue().splitlines()
    assert lines[0].startswith("ukwial at 100 Hz: take z-exact; exact.")
    assert [line.split()[0] for line in lines[3:6]] == ["z-exact", "b-exact", "a-rule"]


def test_no_row_shows_a_p99_below_its_p50(tmp_path: Path) -> None:
    """A slow set with few calls has no p99: then the method has none, though its other sets have."""
    quick = cell("m", key=Key("ukwial", "active", "m"))
    slow = cell("m", us=500, key=Key("ukwial", "infeasible", "m"), singles=[(500_000, 20)])
    run = made_up.run(tmp_path, quick, slow)
    text = StringIO()
    show(tmp_path, Console(file=text))
    (line,) = [line for line in text.getvalue().splitlines() if line.startswith("m ")]
    assert line.split()[:3] == ["m", "1.00…500", "yes"]
    # Batches that took longer than single calls did were measured on a machine that did something else.
    held_up = cell("m", us=50)
    (row,) = made_up.run(tmp_path, held_up).rows
    assert run.rows[0].call_p99_us is not None
    assert (row.call_p50_us, row.call_p99_us, row.call_p99_high_us) == (50.0, None, None)


def test_a_log_s_misses_are_shown_although_it_asks_too_much_as_well(tmp_path: Path) -> None:
    log = on("dive", "clip", 0.9, 0.1)
    judged = msgspec.structs.replace(log.judged, missed_max=0.19)
    run = made_up.run(tmp_path, msgspec.structs.replace(log, judged=judged))
    assert miss_text(list(run.rows)) == "19%"
