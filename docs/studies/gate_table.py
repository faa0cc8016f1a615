"""How often the gate finds a change, and how often none: ``python docs/studies/gate_table.py FILE``.

``docs/studies/gate_proof.py`` wrote the trials in FILE; results/studies/gate_table.md is the table.
"""

import json
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

from bench.results.text import table

SLOWER = {"up05": 5, "up10": 10, "up20": 20}
"""Additional work in per cent, by tree."""

Says = Callable[[dict[str, Any]], bool | None]

RULES: tuple[tuple[str, str, Says], ...] = (
    ("gate: time", "gate", lambda cell: cell["time"]),
    ("gate: instructions", "gate", lambda cell: cell.get("trips")),
    ("gate: either", "gate", lambda cell: cell["time"] or cell["trips"] if "trips" in cell else None),
    (
        "one run after the other, median > +10 % (--benchmark-compare-fail)",
        "pytest",
        lambda c: c["median"] > 1.1,
    ),
    ("the same, mean > +10 %", "pytest", lambda cell: cell["mean"] > 1.1),
    ("the same, median > +3 %, the gate's threshold", "pytest", lambda cell: cell["median"] > 1.03),
)
"""The rows of the table: a rule, the kind of its trials, and whether it calls a cell slower, None where it
can't say."""

HEADERS = (
    "rule",
    "identical: trials",
    "with a false alarm",
    "cells",
    "+5 % found",
    "+10 %",
    "+20 %",
    "s a trial",
)
QUIET_LOAD = 2.0
"""Load average at the start of a trial up to which the load may come from the trials themselves."""


def report(trials: list[dict[str, Any]]) -> str:
    """A table for a quiet machine and one for a loaded machine, as far as there are trials."""
    quiet = [trial for trial in trials if trial["load"] <= QUIET_LOAD]
    loaded = [trial for trial in trials if trial["load"] > QUIET_LOAD]
    named = {"Quiet machine": quiet, "Loaded machine": loaded}
    return "\n\n".join(f"### {name}\n\n{summary(part)}" for name, part in named.items() if part)


def summary(trials: list[dict[str, Any]]) -> str:
    """False alarms and finds of each rule, and the time of a trial."""
    rows = []
    for title, by, says in RULES:
        alarms = {
            name: [_alarms(trial, says) for trial in trials if trial["by"] == by and trial["tree"] == name]
            for name in ("same", *SLOWER)
        }
        false = sum(any(cells) for cells in alarms["same"])
        cells = [alarm for trial in alarms["same"] for alarm in trial]
        finds = [_share([alarm for trial in alarms[name] for alarm in trial]) for name in SLOWER]
        seconds = median([t["seconds"] for t in trials if t["by"] == by and t["tree"] == "same"] or [0.0])
        judged = sum(bool(trial) for trial in alarms["same"])
        rows.append(
            [title, str(judged), str(false), f"{sum(cells)} of {len(cells)}", *finds, f"{seconds:.0f}"]
        )
    same = Counter(t["outcome"] for t in trials if t["by"] == "gate" and t["tree"] == "same")
    loads = sorted(t["load"] for t in trials)
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in same.most_common())
    ratios = {
        name: median(
            c["ratio"] for t in trials if t["by"] == "gate" and t["tree"] == name for c in t["cells"].values()
        )
        for name in SLOWER
        if any(t["by"] == "gate" and t["tree"] == name for t in trials)
    }
    injected = ", ".join(f"{SLOWER[name]} % as {ratio - 1:.1%}" for name, ratio in ratios.items())
    return (
        f"{table(HEADERS, rows)}\n"
        f"Gates between identical trees ended with: {outcomes}. Load average when a trial began: "
        f"{loads[0]:.1f} … {loads[-1]:.1f}, median {median(loads):.1f}. The gate measured what was injected, "
        f"in the median, {injected}."
    )


def _alarms(trial: dict[str, Any], says: Says) -> list[bool]:
    # A rule can't say anything (None) of instructions where a trial did not count them.
    return [bool(alarm) for cell in trial["cells"].values() if (alarm := says(cell)) is not None]


def _share(alarms: list[bool]) -> str:
    return f"{sum(alarms) / len(alarms):.0%} of {len(alarms)}" if alarms else "–"


if __name__ == "__main__":
    print(report([json.loads(line) for line in Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()]))
