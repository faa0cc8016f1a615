"""The table in results/studies/gate_table.md is what the trials give."""

import json
from typing import Any

from gate_table import report, summary
from tests.places import DOCS, ROOT
from tests.renderings import differences


def trial(by: str, tree: str, *cells: dict[str, Any], outcome: str = "pass") -> dict[str, Any]:
    named = {str(i): cell for i, cell in enumerate(cells)}
    return {"by": by, "tree": tree, "load": 1.0, "seconds": 3.0, "outcome": outcome, "cells": named}


def line(table: str, start: str) -> list[str]:
    row = next(row for row in table.splitlines() if row.startswith(f"| {start}"))
    return [entry.strip() for entry in row.strip("|").split("|")][1:]


QUIET = {"ratio": 1.0, "time": False}
SLOWER = {"ratio": 1.05, "time": True}
MISSED = {"ratio": 1.05, "time": False}


def test_false_alarms_are_counted_in_trials_and_in_cells() -> None:
    trials = [
        trial("gate", "same", QUIET, QUIET),
        trial("gate", "same", SLOWER, SLOWER, outcome="regression"),
    ]
    assert line(summary(trials), "gate: time")[:3] == ["2", "1", "2 of 4"]
    assert "1 pass, 1 regression" in summary(trials)


def test_finds_are_a_share_of_the_cells_of_that_tree() -> None:
    trials = [trial("gate", "same", QUIET), trial("gate", "up05", SLOWER, SLOWER, SLOWER, MISSED)]
    assert line(summary(trials), "gate: time")[3:6] == ["75% of 4", "–", "–"]
    assert "5 % as 5.0%" in summary(trials)


def test_the_rule_on_instructions_leaves_out_trials_that_did_not_count_them() -> None:
    trials = [trial("gate", "same", QUIET), trial("gate", "up10", SLOWER, {**MISSED, "trips": True})]
    assert line(summary(trials), "gate: instructions") == ["0", "0", "0 of 0", "–", "100% of 1", "–", "3"]
    assert line(summary(trials), "gate: either")[4] == "100% of 1"


def test_the_rules_of_pytest_benchmark_use_its_own_trials() -> None:
    trials = [trial("gate", "same", QUIET), trial("pytest", "same", {"median": 1.11, "mean": 1.0})]
    table = summary(trials)
    assert line(table, "one run after the other")[:3] == ["1", "1", "1 of 1"]
    assert line(table, "the same, mean")[:3] == ["1", "0", "0 of 1"]


def test_trials_on_a_quiet_and_on_a_loaded_machine_have_tables_of_their_own() -> None:
    quiet, loaded = trial("gate", "same", QUIET), {**trial("gate", "same", QUIET), "load": 9.0}
    assert report([quiet]).count("| rule ") == 1
    assert "### Quiet machine" in report([quiet])
    both = report([quiet, loaded, loaded])
    assert [line(part, "gate: time")[0] for part in both.split("### Loaded machine")] == ["1", "2"]


def test_the_kept_table_is_that_of_the_trials_in_docs() -> None:
    text = (ROOT / "results/studies/gate_table.md").read_text(encoding="utf-8")
    trials = [json.loads(row) for row in (DOCS / "gate_proof.jsonl").read_text(encoding="utf-8").splitlines()]
    assert differences(text.split("\n\n", 2)[2].strip(), report(trials)) == []
