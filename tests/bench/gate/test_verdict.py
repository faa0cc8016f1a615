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


def record(*cells: GateCell, **facts: Any) -> GateRecord:
    return GateRecord(base="a", head="b", settings=GateSettings(), cells=[*cells], **facts)


def control(ratio: float = 1.0, method: str = "loop", **facts: Any) -> GateCell:
    return GateCell(vehicle="control", method=method, **timed(ratio, **facts))


def judged(*cells: GateCell, **facts: Any) -> Verdict:
    return verdict(record(control(), control(method="product"), *cells, **facts))


NEW = GateCell(vehicle="ukwial", method="svd", base_lacks="no such method")
NEW_AND_WRONG = GateCell(
    vehicle="ukwial", method="svd", base_lacks="no such", head_wrong="off", turned_wrong="off"
)
GONE = GateCell(vehicle="ukwial", method="svd", head_lacks="no such method")
CUT, UNDECIDED = {"cut": "the budget was spent"}, "no answer got worse; inconclusive about time: "
PASS, REGRESSION, INCONCLUSIVE = Outcome.PASS, Outcome.REGRESSION, Outcome.INCONCLUSIVE
CASES: dict[str, tuple[list[GateCell], dict[str, str], Outcome, str]] = {
    "equal times": ([cell()], {}, PASS, "pass: 1 cell"),
    "no fresh pairs confirm it": ([cell(**timed(1.2, pairs=10))], {}, PASS, "pass"),
    "below the threshold": ([cell(**timed(1.029))], {}, PASS, "pass"),
    "above it": ([cell(), cell("svd", **timed(1.05))], {}, REGRESSION, "regression: slower"),
    "a short call below the threshold": ([cell(**timed(1.029, us=0.7))], {}, PASS, "pass"),
    "a short call above it": ([cell(**timed(1.031, us=0.7))], {}, REGRESSION, "regression: slower"),
    "not certain": ([cell(**timed(1.04, spread=0.2))], {}, PASS, "pass"),
    "a new cell beside another": ([cell(), NEW], {}, PASS, "pass: 1 cell"),
    "no cell stands on both sides": ([NEW], {}, INCONCLUSIVE, "nothing to compare"),
    "no cell at all": ([], {}, INCONCLUSIVE, "nothing to compare"),
    "two counts grew": (
        [cell(instructions=[(1000, 1011)] * 2)], {}, REGRESSION, "regression: more instructions per call"
    ),
    "one count grew": ([cell(instructions=[(1000, 1011), (1000, 1009)])], {}, PASS, "pass"),
    "one count alone": ([cell(instructions=[(1000, 1011)])], {}, PASS, "pass"),
    "counts, though controls moved": (
        [cell(instructions=[(100, 110)] * 2), control(1.5)], {}, REGRESSION, "regression: more instructions"
    ),
    "a control moved": (
        [cell(**timed(1.2)), control(1.035)], {}, INCONCLUSIVE, f"{UNDECIDED}cells that no commit can change"
    ),
    "a control got faster": ([cell(**timed(1.2)), control(1 / 1.035)], {}, INCONCLUSIVE, UNDECIDED),
    "a spent budget, and a control of few pairs": (
        [cell(), control(1.035, pairs=2)], CUT, INCONCLUSIVE, f"{UNDECIDED}the budget was spent"
    ),
    "a spent budget": ([cell(**timed(1.2))], CUT, INCONCLUSIVE, UNDECIDED),
    "twice as long, in a spent budget": ([cell(**timed(20.0))], CUT, REGRESSION, "regression: slower"),
    "so are the controls": ([cell(**timed(20.0)), control(20.0)], CUT, INCONCLUSIVE, UNDECIDED),
    "wrong, however fast": (
        [cell(**timed(0.5), turned_wrong="off")], {}, REGRESSION, "regression: answers are wrong"
    ),
    "another answer is not called wrong": (
        [cell(**timed(0.5), differ="PARTIAL → SOLVED")], {}, REGRESSION, "regression: other answers"
    ),
    "a cell that is gone comes first": (
        [GONE, cell(turned_wrong="off"), control(2.0)], CUT, REGRESSION, "regression: cells are gone"
    ),
    "new, and wrong": ([NEW_AND_WRONG], {}, REGRESSION, "regression: answers are wrong"),
    "new, and wrong, beside another": ([cell(), NEW_AND_WRONG], {}, REGRESSION, "regression: answers are"),
    "unchanged": ([], {"unchanged": "only the README differs"}, PASS, "pass at once: only the README"),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_each_rule_makes_the_outcome_in_its_order(case: str) -> None:
    cells, facts, outcome, summary = CASES[case]
    result = judged(*cells, **facts)
    assert result.outcome is outcome
    assert result.summary.startswith(summary)
    if not facts:
        crashed = judged(cell(), *cells, crashed="head: ended with SIGSEGV")
        assert crashed.outcome is Outcome.REGRESSION


def test_each_regression_and_improvement_is_named() -> None:
    slow, gone = judged(cell(), cell("svd", **timed(1.05))), judged(GONE, cell(turned_wrong="off"))
    assert [finding.cell for finding in slow.findings] == ["ukwial:svd:-"]
    assert [finding.cell for finding in gone.findings] == ["ukwial:svd:-", "ukwial:pinv:-"]
    assert judged(NEW_AND_WRONG).findings == [("ukwial:svd:-", "new, and wrong: off")]
    faster = judged(cell(**timed(0.9)))
    assert faster.outcome is Outcome.PASS
    assert [row.name for row in faster.improvements] == ["ukwial:pinv:-"]
    assert "control:loop" in judged(cell(**timed(1.2)), control(1.035)).summary


def test_a_suspicion_needs_less_certainty_than_a_failure() -> None:
    doubtful = cell(**timed(1.035, spread=0.1))
    assert 1.0 < ratio(doubtful.pairs).lower < 1.01
    assert is_suspect(doubtful, GateSettings())
    assert judged(doubtful).outcome is Outcome.PASS


@pytest.mark.parametrize(
    ("base", "head", "said"), [("off", "off by 2 N", "base off; head off by 2 N"), ("off", "off", "off")]
)
def test_an_answer_that_is_wrong_on_both_sides_is_noted_with_what_each_did_and_passes(
    base: str, head: str, said: str
) -> None:
    both = record(cell(base_wrong=base, head_wrong=head))
    assert verdict(both).outcome is Outcome.PASS
    assert f"wrong on both sides: `ukwial:pinv:-`: {said}\n" in markdown(both, verdict(both))
    new = record(cell(), NEW_AND_WRONG)  # it is called new once
    assert "- new: " not in markdown(new, verdict(new))


def test_the_report_shows_a_slower_cell_with_its_times_interval_and_instructions() -> None:
    slow = cell(**timed(1.1, us=5.0), instructions=[(1000, 1100), (1000, 1100)])
    made = record(slow, commits=["1234567 Make it slower"])
    text = markdown(made, verdict(made))
    assert text.startswith("## ❌ Gate: regression")
    rows = [" ".join(line.split()) for line in text.splitlines()]
    row = next(row for row in rows if row.startswith("| `ukwial:pinv:-` | 5.000 |"))
    assert "| 1.100 | 1.099 … 1.101 | +10.00% |" in row
    assert "+10.00%" in row
    assert "1234567 Make it slower" in text
    assert '"exit_code": 1' in as_json(made, verdict(made))


def test_a_message_with_bars_and_lines_stays_one_cell_of_the_report() -> None:
    made = record(cell(head_lacks="head: it said a | b\nand c"))
    text = markdown(made, verdict(made))
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
    commits, notes = [f"<img src=http://x> {evil}"], [f"`ukwial:pinv:-`: {evil}"]
    made = record(cell(), notes=notes, commits=commits)
    text = markdown(made, verdict(made))
    assert "- `ukwial:pinv:-`: a \\| b # Heading" in text
    assert "\n#" not in text[1:]
    assert "\x1b" not in text
    assert "](http" not in text.replace("\\](http", "")
    assert "<img" not in text.replace("\\<img", "")
