"""The method to take, in a sentence; how sure that is; one report of several machines."""

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from msgspec.structs import replace

from bench.__main__ import cli
from bench.record import Capability, Cell, Judged, Key, Method, Problem, Quiet
from bench.report import together
from bench.report.sections.headline import opening
from bench.report.verdict import log_rate_hz, rank_notes, rate_note, trust_note, usual_verdicts, verdicts
from bench.results.machines import read_machines
from bench.results.rows import read_run
from bench.results.size import Fit, Loop, Size
from bench.results.sizing import part_note, sizes
from tests import made_up
from tests.bench.results.test_sizing import steady

GENERATED = Method(name="nullspace@native", twin="nullspace", formulation="hard", foreign=True)


def said(directory: Path, rate_hz: float, *lines: Capability | Cell | Method | Problem) -> str:
    """The sentence on the one vehicle of a record."""
    run = made_up.run(directory, *lines)
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
        "ukwial at 100 Hz: take nullspace as generated C; exact. It takes under 0.01 % of the period."
        " qp/daqp would do too."
    )


def test_where_no_exact_method_keeps_up_the_sentence_says_which_is_too_slow(tmp_path: Path) -> None:
    cells = [steady("qp/daqp", 70, exact=True), steady("clip", 2, exact=False)]
    assert said(tmp_path, 10_000, *cells) == (
        "ukwial at 10000 Hz: take clip; not exact. It takes 2.00 % of the period. qp/daqp is exact but too"
        " slow."
    )


@pytest.mark.parametrize(
    ("served", "taken"),
    [
        ((0.5, 0.97), "take mine;.* No exact method was measured.$"),  # the quicker one would not do
        ((0.93, 0.97), "take mine;.* clip would do too.$"),  # as good, but for a few of a hundred
        ((0.95, 1.0), "take mine;.* No exact method was measured.$"),
        ((0.02, 0.04), "take mine;.* clip would do too.$"),
    ],
)
def test_of_rules_that_fit_the_one_that_delivers_more_is_taken(
    served: tuple[float, float], taken: str, tmp_path: Path
) -> None:
    """Beside a closed form alone, a plug-in that served 98 % lost to 60 %, for microseconds."""
    cells = []
    for method, us, share in zip(("clip", "mine"), (2, 60), served, strict=True):
        cell = steady(method, us, exact=False)
        judged = replace(cell.judged, missed_max=1.0 - share, loss={"within_1pct_share": 0.8 * share})
        cells.append(replace(cell, judged=judged))
    problem = replace(made_up.problem("ukwial"), labels={"active": 8, "infeasible": 2})
    assert re.search(taken, said(tmp_path, 100, problem, *cells))


OPEN = ". Not decided by so few: {} may come first."


@pytest.mark.parametrize(("n", "is_open"), [(20, True), (5000, False)])
def test_it_is_said_where_so_few_demands_leave_the_first_choice_open(
    n: int, is_open: bool, tmp_path: Path
) -> None:
    """Either of two rules that serve 72 and 68 % may serve more of ten times the demands."""
    cells = []
    for method, share in (("clip", 0.72), ("mine", 0.68)):
        cell = made_up.judge(
            steady(method, 2, exact=False), missed_max=0.5, loss={"within_1pct_share": share}
        )
        cells.append(replace(cell, n_demands=n))
    text = said(tmp_path, 100, made_up.problem("ukwial"), *cells)
    assert text.startswith("ukwial at 100 Hz: take clip;")
    assert (OPEN.format("mine") in text) == is_open


@pytest.mark.parametrize(("n", "share", "is_open"), [(20, 0.95, True), (20, 0.5, False), (5000, 0.68, False)])
def test_a_rule_that_missed_none_of_few_demands_is_no_sure_choice(
    n: int, share: float, is_open: bool, tmp_path: Path
) -> None:
    """A rule missed some of ten times as many, and another came first."""
    cells = []
    for method, served, missed in (("clip", 1.0, 0.0), ("mine", share, 0.5)):
        cell = made_up.judge(
            steady(method, 2, exact=False), missed_max=missed, loss={"within_1pct_share": served}
        )
        cells.append(replace(cell, n_demands=n))
    text = said(tmp_path, 100, made_up.problem("ukwial"), *cells)
    assert text.startswith("ukwial at 100 Hz: take clip;")
    assert (OPEN.format("mine") in text) == is_open


@pytest.mark.parametrize(
    ("missed", "others", "more", "is_open"),
    [
        (0, 0, 0, False),  # both miss none
        (600, 0, 0, False),  # both miss the same, at the very edge of a tenth
        (610, 12, 0, True),  # either misses 12 that the other meets, or fewer of ten times as many
        (610, 12, 12, True),  # the other misses 24 that the first meets, who misses 12 of its own
        (610, 0, 6, False),  # one misses six more, and none less: McNemar's p is 0.03
        (610, 0, 5, True),  # five: 0.06
    ],
)
def test_rules_are_compared_demand_by_demand(
    missed: int, others: int, more: int, is_open: bool, tmp_path: Path
) -> None:
    """A rule and its library's form, which answer alike, each left the other's choice open."""
    cells, served = [], []
    for method, start, end in (("clip", 0, missed), ("shrink", others, others + missed + more)):
        bits = np.packbits([start <= i < end for i in range(2000)]).tobytes()
        served.append(made_up.served(method, 2000 - end + start, 2000, missed=bits))
        # Of so few timed demands one seems to miss more: that decides nothing.
        cell = steady(method, 2, exact=False)
        cells.append(made_up.judge(cell, missed_max=0.5, loss={"within_1pct_share": 0.5 + start / 1000}))
        cells[-1].formulation, cells[-1].n_demands = method, 20
    lines = (made_up.problem("ukwial"), made_up.capability(served=served), *cells)
    text = said(tmp_path, 100, *lines)
    assert text.startswith("ukwial at 100 Hz: take clip;")
    assert (OPEN.format("shrink") in text) == is_open
    assert "shrink would do too" in text


@pytest.mark.parametrize(("us", "is_open"), [(600, False), (700, True), (1400, True), (1600, False)])
def test_it_is_said_where_a_median_lies_as_near_to_the_limit_as_noise_moves_it(
    us: float, is_open: bool, tmp_path: Path
) -> None:
    cells = [steady("exact", us, exact=True), steady("clip", 2, exact=False)]
    taken, other = ("exact", "clip") if us < 1000 else ("clip", "exact")
    text = said(tmp_path, 100, *cells)
    assert text.startswith(f"ukwial at 100 Hz: take {taken};")
    assert (OPEN.format(other) in text) == is_open


@pytest.mark.parametrize(
    ("ranks", "expected"),
    [
        ((3, 3, 3), []),
        ((3, 1, 3), [" without thruster 0 are shares of a line"]),
        ((3, 2, 2), [" without any one thruster are shares of a plane"]),
        ((2, 1, 2), [" without thruster 0 are shares of a line", " are shares of a plane"]),
    ],
)
def test_of_what_shares_are_is_said_at_the_beginning_where_rank_is_lost(
    ranks: tuple[int, ...], expected: list[str], tmp_path: Path
) -> None:
    """A line that is left is served whole by anything, and 100 % said nothing of the rest."""
    whole = made_up.capability().authority[0]
    states = [replace(whole, fault=i - 1 if i else None, rank=rank) for i, rank in enumerate(ranks)]
    run = made_up.run(
        tmp_path,
        made_up.problem("ukwial"),
        steady("clip", 2, exact=True),
        made_up.capability(authority=states),
    )
    assert rank_notes(run) == [f"ukwial: shares served{text}: no more can be pushed." for text in expected]
    assert all(f"- {note}" in opening(run, frozenset()) for note in rank_notes(run))


def test_where_nothing_fits_the_sentence_says_by_how_much(tmp_path: Path) -> None:
    assert said(tmp_path, 1000, steady("m", 250, exact=True)) == (
        "ukwial at 1000 Hz: nothing here fits 10.0 % of the period;"
        " the fastest median is 25.0 % of the period."
    )


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (("--machine", "nope"), "no machine 'nope' here; there is example-cpu-2-cores"),
        (("--deadline-us", "2000"), "--deadline-us 2000: is longer than the period of 1000 Hz, 1000 µs"),
    ],
)
def test_size_of_one_run_refuses_a_machine_that_it_has_not_and_a_deadline_beyond_the_period(
    tmp_path: Path, asked: tuple[str, ...], why: str
) -> None:
    made_up.record(tmp_path, made_up.header(), steady("m", 1500, exact=True))
    result = CliRunner().invoke(cli, ["size", str(tmp_path), "--rate", "1000", *asked])
    assert result.exit_code != 0
    assert why in f"{result.exception} {result.output}"


def log(**facts: Any) -> Problem:
    """A log of ten demands at 50 Hz that a user brought, some of which can't be met."""
    labels = {"active": 8, "infeasible": 2}
    asked = replace(made_up.problem("ukwial"), demands="dive", labels=labels, rate_hz=50.0, given=True)
    return replace(asked, **facts)


def test_the_rate_of_a_log_is_a_number_that_people_write(tmp_path: Path) -> None:
    """Time stamps are rounded, so the median step between them is 0.02 s but for the last digits."""
    made = made_up.record(tmp_path, made_up.header(), log(rate_hz=49.99999999995))
    assert log_rate_hz(read_run(made)) == 50.0


def on_log(method: str, us: float, answered: float = 1.0, refused_longest: int = 0) -> Cell:
    """A method that is exact where a demand can be met, and answers that share of the log."""
    cell = steady(method, us, exact=True)
    judged = replace(cell.judged, loss={"answered_share": answered}, refused_longest=refused_longest)
    formulation = method if method == "scaled" else cell.formulation
    return replace(made_up.rename(cell, demands="dive"), judged=judged, formulation=formulation)


PICKY, ALL = on_log("nullspace", 1, 0.8, 2), on_log("scaled", 2)
DRAWN: dict[str, Any] = {"given": False, "rate_hz": None}
EASY = {"labels": {"active": 10}}
IDLE = made_up.judge(on_log("scaled", 1, 1.0, 2), nothing_share=0.2)
STILL = made_up.judge(steady("idle", 1, exact=False), missed_max=1.0)
WEAK = made_up.judge(steady("weak", 1, exact=False), missed_max=0.98, missed_p50=0.98)
BEYOND = made_up.judge(on_log("pinv", 0.5), loss={"answered_share": 1.0, "limits_violated_share": 0.2})
BEYOND = replace(BEYOND, formulation="unlimited")
CLIP = steady("clip", 2, exact=False)
NOBODY = made_up.judge(on_log("nullspace", 1, 0.0, 10), agrees=None, distance_rel_max=None)
PARTLY = "nullspace refuses 20.0 % of dive's demands, up to 0.0400 s at a stretch."
NOT_EXACT = "No exact method was measured."
RULE = f"take clip; not exact, answers every demand. It takes 0.0100 % of the period. {NOT_EXACT}"
SENTENCES: dict[str, tuple[Problem | None, list[Cell], str]] = {
    "of a log what answers all is taken, and who refuses some is named with the longest stretch": (
        log(), [PICKY, ALL], "take scaled; exact, answers every demand. It takes 0.0100 % of the period."
        f" {PARTLY}"),
    "a log without a rate has a stretch of demands": (
        log(rate_hz=None), [PICKY], "take nullspace; exact. It takes under 0.01 % of the period. It refuses"
        " 20.0 % of dive's demands, up to 2 demands in a row."),
    "a mission is a dive as a log is, but its share beyond reach is drawn": (
        log(given=False), [PICKY, ALL], "take scaled; exact, answers every demand. It takes 0.0100 % of the"
        " period. nullspace refuses what can't be met of dive."),
    "a mission that was asked in part says so in the same sentence": (  # red before: no word of it
        log(given=False, left_out=2990), [PICKY, ALL], "take scaled; exact, answers every demand; of dive's"
        " 3,000 demands 10 asked. It takes 0.0100 % of the period. nullspace refuses what can't be met of"
        " dive."),
    "where all refuse a mission that was asked in part the sentence says so too": (
        log(given=False, left_out=2990), [made_up.rename(STILL, demands="dive")],
        "nothing to take; of dive's 3,000 demands 10 asked. idle refuses some of what can be met."),
    "a log that nothing can meet names who refuses all of it, though no answer showed it exact": (
        log(labels={"infeasible": 10}), [NOBODY, ALL],
        "… nullspace refuses 100 % of dive's demands, up to 0.200 s at a stretch."),
    "shares of drawn demands are not given, and who refuses would not do where the first answers all": (
        log(**DRAWN), [on_log("nullspace", 2, 0.8), on_log("scaled", 1)],
        "take scaled; exact, answers every demand. It takes under 0.01 % of the period. nullspace refuses"
        " what can't be met."),
    "what answers all goes before who refuses what was drawn beyond reach, for microseconds": (
        log(**DRAWN), [on_log("nullspace", 1, 0.8), on_log("scaled", 9)], "take scaled; exact, answers every"
        " demand. It takes 0.0450 % of the period. nullspace refuses what can't be met."),
    "who refuses what was drawn beyond reach is named as such": (
        log(**DRAWN), [PICKY], "take nullspace; exact. It takes under 0.01 % of the period. It refuses what"
        " can't be met."),
    "what stands in for an exact method that refuses has a rival, and thrusts beyond limits are named": (
        log(), [PICKY, replace(on_log("pinv", 0.5), formulation="unlimited")],
        "take pinv; not exact, answers every demand. It takes under 0.01 % of the period. It knows no limits."
        f" nullspace is exact but refuses some demands. {PARTLY}"),
    "thrusts beyond limits are no answer to what was drawn beyond reach": (
        log(**DRAWN), [on_log("nullspace", 1, 0.8), BEYOND], "take nullspace; exact. It takes under 0.01"
        " % of the period. It refuses what can't be met."),
    "of a log asked in part what it holds beyond reach counts whole": (  # 300 of 990 others, 125 in a row
        log(**EASY, left_out=990, beyond=300, beyond_longest=125), [on_log("nullspace", 1), ALL],
        "take scaled; exact, answers every demand. It takes 0.0100 % of the period. nullspace refuses 30.0 %"
        " of dive's demands, up to 2.50 s at a stretch."),
    "a solver that gave up on what another meets is no refusal of the log": (
        log(**EASY), [on_log("nullspace", 1), on_log("qp/qoco@generated", 9, 0.9, 1), ALL],
        "take scaled; exact, answers every demand. It takes 0.0100 % of the period."),
    "who refuses is named also of a log that can be met, for another may pass the limits": (
        log(**EASY), [on_log("nullspace", 1)], "take nullspace; exact. … It refuses what can't be met."),
    "who answers all is not said to refuse": (log(**EASY), [ALL], "take scaled; exact. It … period."),
    "what gives nothing of a part of a log is not taken where another delivers": (  # no thrust astern
        log(), [PICKY, IDLE, made_up.rename(on_log("scaled", 9), method="scaled-by-group")],
        f"take scaled-by-group; exact, answers every demand. It takes 0.0450 % of the period. {PARTLY}"),
    "what gives nothing of a part of a log is named where there is no other": (
        log(), [IDLE], "take scaled; exact. It takes under 0.01 % of the period. It refuses 20.0 % of dive's"
        " demands by giving nothing, up to 0.0400 s at a stretch."),
    "what gives no thrust for a demand that can be met is not taken": (None, [STILL, CLIP], RULE),
    "nothing is taken where all refuse": (
        None, [STILL], "nothing to take. idle refuses some of what can be met."),
    "what gives two per cent of most demands is not taken and would not do too": (None, [WEAK, CLIP], RULE),
    "what gives little of most demands is no choice alone": (
        None, [WEAK], "nothing to take. weak refuses 25.0 % and more of most demands that can be met."),
}  # fmt: skip


@pytest.mark.parametrize(("asked", "cells", "expected"), SENTENCES.values(), ids=SENTENCES.keys())
def test_the_sentence_says_who_refuses_what(
    asked: Problem | None, cells: list[Cell], expected: str, tmp_path: Path
) -> None:
    sentence = said(tmp_path, 50, *([asked] if asked else []), *cells).removeprefix("ukwial at 50 Hz: ")
    start, gap, end = expected.partition("…")
    assert sentence == expected or (gap and sentence.startswith(start) and sentence.endswith(end))


@pytest.mark.parametrize(("asked", "left_out"), [(2, 0), (0, 990)])
def test_limits_that_cross_are_refused_by_all_and_no_method_without_limits_is_taken_for_them(
    tmp_path: Path, asked: int, left_out: int
) -> None:
    """One of sixty demands had such limits, and the pseudoinverse was to be taken, since it answers all."""
    limited = [
        replace(on_log(m, us, 1 - asked / 10, 2), limited=True) for m, us in (("nullspace", 2), ("clip", 3))
    ]
    cells = [*limited, replace(on_log("pinv", 1), formulation="unlimited")]
    cells[1] = replace(cells[1], formulation="clip")
    crossing = log(crossed=2, crossed_asked=asked, left_out=left_out)
    assert said(tmp_path, 50, crossing, *cells) == (
        "ukwial at 50 Hz: take nullspace; exact. It takes 0.0100 % of the period. It refuses what can't be"
        " met, and limits that cross."
    )
    fewer = [replace(limited[0], judged=on_log("nullspace", 2, 0.7, 2).judged), *cells[1:]]
    more = log(crossed=2, crossed_asked=2, beyond=1, beyond_longest=1)  # the stretch too is without them
    assert (
        "nullspace refuses 10.0 % of dive's demands, up to 0.0200 s at a stretch, and limits that cross"
        in said(tmp_path, 50, more, *fewer)
    )


@pytest.mark.parametrize("limited", [True, False])
def test_a_plug_in_that_promises_no_limits_is_named_as_such(tmp_path: Path, limited: bool) -> None:
    """An unclipped pseudoinverse of a user's own was "a rule within limits", and taken as one."""
    described = Method(name="mine", formulation="mine", plugin=True)
    cell = replace(on_log("mine", 1), formulation="mine", limited=limited)
    line = said(tmp_path, 50, described, log(), cell)
    assert ("knows no limits" in line) != limited
    (row,) = read_run(tmp_path).rows
    assert row.title == ("a rule within limits" if limited else "a rule that promises no limits")


@pytest.mark.parametrize(("moving", "given", "said_so"), [(True, True, True), (False, True, False)])
def test_c_for_limits_that_move_is_named_with_its_option(
    tmp_path: Path, moving: bool, given: bool, said_so: bool
) -> None:
    """The timed method took the limits of each call; C without them exceeds those of a moment."""
    native = on_log("scaled@native", 1)
    described = Method(name="scaled@native", formulation="scaled", twin="scaled")
    lines = (described, log(moving=moving, given=given), native)
    assert ("take scaled as generated C with --limits call; exact" in said(tmp_path, 50, *lines)) == said_so


def test_a_vehicle_without_freedom_is_told_that_there_is_none_to_gain_from(tmp_path: Path) -> None:
    square = replace(made_up.problem("ukwial"), n=3, nullity=0)
    assert "No spare thruster" in said(tmp_path, 100, square, steady("pinv", 1, exact=True))
    assert "spare" not in said(tmp_path, 100, made_up.problem("ukwial"), steady("pinv", 1, exact=True))


def test_vehicles_with_the_same_verdict_share_a_line(tmp_path: Path) -> None:
    cells = [
        made_up.rename(cell, vehicle=vehicle)
        for vehicle, us in (("a", 1), ("b", 1), ("c", 900))
        for cell in [steady("nullspace", us, exact=True)]
    ]
    loop = Loop(100)
    lines = verdicts(sizes(made_up.run(tmp_path, *cells), loop), loop)
    assert [line.partition(" at 100 Hz: ")[0] for line in lines] == ["a, b", "c"]


def test_a_log_s_own_rate_is_the_rate_of_the_report_and_of_size(tmp_path: Path) -> None:
    made_up.record(tmp_path, made_up.header(), log(), on_log("scaled", 2))
    assert usual_verdicts(read_run(tmp_path))[0].startswith("ukwial at 50 Hz: take scaled")
    assert CliRunner().invoke(cli, ["size", str(tmp_path)]).output.startswith("ukwial at 50 Hz: take scaled")
    made_up.record(tmp_path, made_up.header(), log(given=False), on_log("scaled", 2))
    assert usual_verdicts(read_run(tmp_path))[0].startswith("ukwial at 100 Hz")
    done = CliRunner().invoke(cli, ["size", str(tmp_path)])
    assert done.exit_code == 2
    assert "no log with a rate of its own" in done.output


@pytest.mark.parametrize(("steal", "word"), [(0, "quiet: 0 of 2"), (9, "noisy: 2 of 2")])
def test_how_sure_that_is_counts_the_rows_that_the_machine_disturbed(
    steal: int, word: str, tmp_path: Path
) -> None:
    cells = [replace(steady(name, 1, exact=True), quiet=Quiet(steal_ticks=steal)) for name in "ab"]
    run = made_up.run(tmp_path, *cells)
    assert trust_note(run).startswith(f"{word} rows disturbed")


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


def test_a_report_of_several_machines_opens_at_the_rate_of_the_log_that_both_were_asked(
    tmp_path: Path,
) -> None:
    asked = replace(made_up.problem("ukwial"), rate_hz=50.0, given=True)
    for name in ("fast", "slow"):
        (tmp_path / name).mkdir()
        header = made_up.header(machine={"name": name})
        made_up.record(tmp_path / name, header, asked, steady("nullspace", 2, exact=True))
    both = read_machines([tmp_path / "fast", tmp_path / "slow"])
    assert "- ukwial at 50 Hz on every machine that has it: take nullspace" in together.page(both)


def test_where_logs_have_several_rates_it_is_said_whose_is_taken(tmp_path: Path) -> None:
    """A vehicle whose log has 25 Hz stood at 50 Hz, and nothing said why."""
    folders = []
    logs = (("ukwial", "hot", 25.0), ("rov", "dive", 50.0), ("tug", "trip", 49.9))  # clocks differ so much
    for vehicle, name, rate_hz in logs:
        (tmp_path / vehicle).mkdir()
        asked = replace(made_up.problem(vehicle), demands=name, rate_hz=rate_hz, given=True)
        cell = replace(made_up.exact_cell(vehicle, "nullspace", 2.0), key=Key(vehicle, name, "nullspace"))
        folders.append(made_up.record(tmp_path / vehicle, made_up.header(), asked, cell))
        assert rate_note(read_run(folders[-1])) == []
    said = "The rate is that of the fastest log, dive of rov, for every vehicle. hot of ukwial has 25 Hz."
    assert said in together.page(read_machines(folders))
    asked_of_size = CliRunner().invoke(cli, ["size", *map(str, folders)]).output
    assert said in asked_of_size
    assert said not in CliRunner().invoke(cli, ["size", *map(str, folders), "--rate", "30"]).output


def test_a_report_of_several_machines_has_the_rows_of_all_and_ratios(
    machines: list[Path], tmp_path: Path
) -> None:
    done = CliRunner().invoke(cli, ["report", *map(str, machines), "-o", str(tmp_path / "both")])
    assert done.exit_code == 0, done.output
    text = (tmp_path / "both" / "report.md").read_text(encoding="utf-8")
    assert (
        "- ukwial at 100 Hz on every machine that has it: take nullspace; exact. It takes 0.0600 % of the"
        " period." in text
    )
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
    assert text.startswith("ukwial at 400 Hz on every machine that has it: take nullspace; exact.")
    assert text.splitlines()[2].startswith("fast was quiet")


def test_answers_that_are_wrong_have_no_verdict(tmp_path: Path) -> None:
    judged = Judged(answers=1, counts={"SOLVED": 1}, wrong="limit violated")
    wrong = replace(steady("m", 1, exact=True), judged=judged)
    assert said(tmp_path, 100, wrong).endswith(
        "nothing here fits 10.0 % of the period; none has a time that counts."
    )


@pytest.mark.parametrize("fit", [Fit.FITS, Fit.WITHOUT_TAIL, Fit.MAY_FIT, Fit.DOES_NOT_FIT])
@pytest.mark.parametrize("refused", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("exact", [True, False])
def test_a_verdict_on_which_everything_is_to_be_said_has_no_sentence_that_is_too_long(
    fit: Fit, refused: float, exact: bool
) -> None:
    """It was one sentence, of up to 70 words."""
    words = "100 % of dive's demands by giving nothing, up to 0.0400 s at a stretch, and limits that cross"
    first = Size(
        vehicle="ukwial", method="a@native", label="a@native", twin="a", moving=True,
        fit=fit, reason="the other machine: too few calls", exact=exact, refused=refused,
        refusal=words if refused else "", part=part_note(replace(log(), left_out=2990)),
        p50_us=900.0, calls=10, unlimited=True, freedom=0, missing=0.1,
    )  # fmt: skip
    other = dataclasses.replace(first, method="b@native", twin="b", picky=True, refused=1.0, refusal=words)
    (line,) = verdicts([first, other], Loop(100.0), " on every machine that has it")
    parts = line.removesuffix(".").split(". ")
    assert len(parts) > 1 or fit == Fit.DOES_NOT_FIT
    assert max(len(part.split()) for part in parts) <= 30
