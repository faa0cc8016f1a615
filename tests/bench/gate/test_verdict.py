"""The gate's verdict on frozen records: every rule, its order, and the statistics behind it."""

import random
from math import exp, log
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.gate.record import GateCell, GateRecord, GateSettings
from bench.gate.verdict import Outcome, Verdict, as_json, is_suspect, markdown, medians_us, ratio, verdict

CALLS = 500


def timed(ratio: float = 1.0, us: float = 5.0, spread: float = 0.005, pairs: int = 20) -> dict[str, Any]:
    """Pairs whose ln ratios average ln ``ratio`` and differ from it by at most about ``spread``."""
    rng = random.Random(7)
    noise = [rng.uniform(-spread, spread) for _ in range(pairs)]
    middle = sum(noise) / pairs
    base = round(us * 1e3 * CALLS)
    return {
        "calls": CALLS,
        "pairs": [[(base, round(base * ratio * exp(n - middle)))] * 5 for n in noise],
    }


def cell(method: str = "pinv", **facts: Any) -> GateCell:
    return GateCell(vehicle="ukwial", method=method, **{**timed(), **facts})


def judged(*cells: GateCell, **facts: Any) -> Verdict:
    controls = [
        GateCell(vehicle="control", method="loop", **timed()),
        GateCell(vehicle="control", method="product", **timed()),
    ]
    return verdict(
        GateRecord(base="a", head="b", settings=GateSettings(), cells=[*controls, *cells], **facts)
    )


NEW = GateCell(vehicle="ukwial", method="svd", base_lacks="no such method")
MOVED = GateCell(vehicle="control", method="loop", **timed(1.5))


@pytest.mark.parametrize(
    ("cells", "outcome"),
    [
        pytest.param([cell()], Outcome.PASS, id="equal times"),
        pytest.param([cell(**timed(1.2, pairs=10))], Outcome.PASS, id="no fresh pairs confirm it"),
        pytest.param([cell(**timed(1.029))], Outcome.PASS, id="below the threshold"),
        pytest.param([cell(**timed(1.029, us=0.7))], Outcome.PASS, id="a short call below the threshold"),
        pytest.param([cell(**timed(1.031, us=0.7))], Outcome.REGRESSION, id="a short call above it"),
        pytest.param([cell(), NEW], Outcome.PASS, id="a new cell beside another"),
        pytest.param([NEW], Outcome.INCONCLUSIVE, id="no cell stands on both sides"),
        pytest.param([], Outcome.INCONCLUSIVE, id="no cell at all"),
        pytest.param([cell(instructions=[(1000, 1011)] * 2)], Outcome.REGRESSION, id="two counts grew"),
        pytest.param([cell(instructions=[(1000, 1011), (1000, 1009)])], Outcome.PASS, id="one count grew"),
        pytest.param([cell(instructions=[(1000, 1011)])], Outcome.PASS, id="one count alone"),
        pytest.param(
            [cell(instructions=[(100, 110)] * 2), MOVED],
            Outcome.REGRESSION,
            id="counts, though controls moved",
        ),
    ],
)
def test_times_and_counts_make_the_outcome(cells: list[GateCell], outcome: Outcome) -> None:
    assert judged(*cells).outcome is outcome
    assert judged(cell(), *cells, crashed="head: ended with SIGSEGV").outcome is Outcome.REGRESSION


def test_a_clear_slow_down_fails_and_names_the_cell() -> None:
    result = judged(cell(), cell("svd", **timed(1.05)))
    assert result.outcome is Outcome.REGRESSION
    assert [finding.cell for finding in result.findings] == ["ukwial:svd:-"]


def test_a_slow_down_that_is_not_certain_passes() -> None:
    noisy = timed(1.04, spread=0.2)
    assert ratio(noisy["pairs"]).lower < 1.01
    assert judged(cell(**noisy)).outcome is Outcome.PASS


def test_a_suspicion_needs_less_certainty_than_a_failure() -> None:
    doubtful = cell(**timed(1.035, spread=0.1))
    assert 1.0 < ratio(doubtful.pairs).lower < 1.01
    assert is_suspect(doubtful, GateSettings())
    assert judged(doubtful).outcome is Outcome.PASS


@pytest.mark.parametrize("moved", [1.035, 1 / 1.035])
def test_a_control_cell_that_moves_either_way_makes_the_gate_inconclusive(moved: float) -> None:
    result = judged(cell(**timed(1.2)), GateCell(vehicle="control", method="loop", **timed(moved)))
    assert result.outcome is Outcome.INCONCLUSIVE
    assert "control:loop" in result.summary


def test_a_spent_budget_is_reported_before_a_control_cell_that_moved() -> None:
    result = judged(
        cell(),
        GateCell(vehicle="control", method="loop", **timed(1.035, pairs=2)),
        cut="the budget was spent",
    )
    assert result.outcome is Outcome.INCONCLUSIVE
    assert result.summary == "no answer got worse; inconclusive about time: the budget was spent"


@pytest.mark.parametrize(
    ("what", "summary"),
    [({"turned_wrong": "off"}, "answers are wrong"), ({"differ": "PARTIAL → SOLVED"}, "other answers")],
)
def test_a_wrong_answer_fails_however_fast_it_is_and_another_one_is_not_called_wrong(
    what: dict[str, str], summary: str
) -> None:
    result = judged(cell(**timed(0.5), **what))
    assert result.outcome is Outcome.REGRESSION
    assert result.summary == f"regression: {summary}"


@pytest.mark.parametrize(
    ("base", "head", "said"), [("off", "off by 2 N", "base off; head off by 2 N"), ("off", "off", "off")]
)
def test_an_answer_that_is_wrong_on_both_sides_is_noted_with_what_each_did_and_passes(
    base: str, head: str, said: str
) -> None:
    record = GateRecord(
        base="a", head="b", settings=GateSettings(), cells=[cell(base_wrong=base, head_wrong=head)]
    )
    result = verdict(record)
    assert result.outcome is Outcome.PASS
    assert f"wrong on both sides: `ukwial:pinv:-`: {said}\n" in markdown(record, result)


def test_a_cell_that_is_gone_is_the_first_reason_to_fail() -> None:
    gone = GateCell(vehicle="ukwial", method="svd", head_lacks="no such method")
    moved = GateCell(vehicle="control", method="loop", **timed(2.0))
    result = judged(gone, cell(turned_wrong="off"), moved, cut="no time left")
    assert result.outcome is Outcome.REGRESSION
    assert result.summary == "regression: cells are gone"
    assert result.findings[0].cell == "ukwial:svd:-"


def test_a_new_cell_that_is_wrong_fails_and_is_called_new_once() -> None:
    new = GateCell(vehicle="ukwial", method="svd", base_lacks="no such", head_wrong="off", turned_wrong="off")
    for cells in ([new], [cell(), new]):
        record = GateRecord(base="a", head="b", settings=GateSettings(), cells=cells)
        result = verdict(record)
        assert (result.outcome, result.summary) == (Outcome.REGRESSION, "regression: answers are wrong")
        assert result.findings == [("ukwial:svd:-", "new, and wrong: off")]
        assert "- new: " not in markdown(record, result)


def test_a_budget_that_ran_out_is_inconclusive_but_for_a_cell_that_takes_twice_as_long() -> None:
    cut = "the budget was spent"
    assert judged(cell(**timed(1.2)), cut=cut).outcome is Outcome.INCONCLUSIVE
    slow = judged(cell(**timed(20.0)), cut=cut)
    assert slow.outcome is Outcome.REGRESSION
    assert slow.summary == "regression: slower"
    assert [found.cell for found in slow.findings] == [slow.rows[0].name]
    control = GateCell(vehicle="control", method="sum", **timed(20.0))
    assert judged(cell(**timed(20.0)), control, cut=cut).outcome is Outcome.INCONCLUSIVE


def test_unchanged_trees_pass_with_the_reason() -> None:
    result = verdict(
        GateRecord(base="a", head="b", settings=GateSettings(), unchanged="only the README differs")
    )
    assert result.outcome is Outcome.PASS
    assert "only the README differs" in result.summary


def test_a_cell_that_got_faster_is_listed_as_an_improvement() -> None:
    result = judged(cell(**timed(0.9)))
    assert result.outcome is Outcome.PASS
    assert [row.name for row in result.improvements] == ["ukwial:pinv:-"]


def test_the_report_shows_a_slower_cell_with_its_times_interval_and_instructions() -> None:
    slow = cell(**timed(1.1, us=5.0), instructions=[(1000, 1100), (1000, 1100)])
    record = GateRecord(
        base="a", head="b", settings=GateSettings(), cells=[slow], commits=["1234567 Make it slower"]
    )
    text = markdown(record, verdict(record))
    assert text.startswith("## ❌ Gate: regression")
    rows = [" ".join(line.split()) for line in text.splitlines()]
    row = next(row for row in rows if row.startswith("| `ukwial:pinv:-` | 5.000 |"))
    assert "| 1.100 | 1.099 … 1.101 | +10.00% |" in row
    assert "+10.00%" in row
    assert "1234567 Make it slower" in text
    assert '"exit_code": 1' in as_json(record, verdict(record))


def test_a_message_with_bars_and_lines_stays_one_cell_of_the_report() -> None:
    record = GateRecord(
        base="a", head="b", settings=GateSettings(), cells=[cell(head_lacks="head: it said a | b\nand c")]
    )
    text = markdown(record, verdict(record))
    row = next(line for line in text.splitlines() if line.startswith("| `ukwial:pinv:-`"))
    assert row.replace("\\|", "").count("|") == 3
    assert "b and c" in row


logs = st.lists(st.floats(-0.5, 0.5), min_size=2, max_size=12).filter(lambda m: np.std(m) > 1e-3)


@given(logs)
def test_the_interval_is_student_s_on_the_logarithms_of_the_ratios(m: list[float]) -> None:
    from scipy import stats  # takes a second, in each process that collects tests

    pairs = [[(10**9, round(10**9 * exp(x)))] for x in m]
    values = [log(head / base) for ((base, head),) in pairs]
    low, high = stats.ttest_1samp(values, 0.0).confidence_interval(0.95)
    assert ratio(pairs) == pytest.approx((exp(np.mean(values)), exp(low), exp(high)), rel=1e-9)


@given(logs)
def test_swapping_the_sides_inverts_the_ratio(m: list[float]) -> None:
    pairs = [[(10**9, round(10**9 * exp(x)))] for x in m]
    there, back = ratio(pairs), ratio([[(b, a) for a, b in blocks] for blocks in pairs])
    assert (there.value, there.lower, there.upper) == pytest.approx(
        (1 / back.value, 1 / back.upper, 1 / back.lower)
    )


def test_one_disturbed_block_does_not_move_a_pair() -> None:
    quiet = [[(100, 100)] * 5] * 3
    disturbed = [[(100, 100)] * 4 + [(100, 900)], *quiet[1:]]
    assert ratio(disturbed) == ratio(quiet)


def test_the_interval_of_a_single_pair_reaches_down_to_zero() -> None:
    assert ratio([[(100, 200)]]).lower == 0.0


def test_medians_are_times_of_a_single_call() -> None:
    assert medians_us([[(2_000_000, 3_000_000)]], calls=1000) == (2.0, 3.0)


def test_no_text_of_others_is_markdown_in_the_comment() -> None:
    """A commit's subject and an exception's text made headings, and fetched pictures."""
    evil = "a | b\n# Heading\n![](http://x/y.png) <img src=http://x> \x1b[31mred"
    record = GateRecord(
        base="a", head="b", settings=GateSettings(), cells=[cell()], notes=[f"`ukwial:pinv:-`: {evil}"]
    )
    record.commits = [f"<img src=http://x> {evil}"]
    text = markdown(record, verdict(record))
    assert "- `ukwial:pinv:-`: a \\| b # Heading" in text
    assert "\n#" not in text[1:]
    assert "\x1b" not in text
    assert "](http" not in text.replace("\\](http", "")
    assert "<img" not in text.replace("\\<img", "")
