"""The table of docs/gate.md from what ``bench.studies.gate_proof`` left in FILE.

python -m bench.studies.gate_table FILE
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
"""Tree -> per cent of additional work."""

Says = Callable[[dict[str, Any]], bool | None]

RULES: tuple[tuple[str, str, Says], ...] = (
    ("gate: time", "gate", lambda cell: cell["time"]),
    ("gate: instructions", "gate", lambda cell: cell.get("trips")),
    ("gate: either", "gate", lambda cell: cell["time"] or cell["trips"] if "trips" in cell else None),
    (
        "one run after the other, median > +10 % (`--benchmark-compare-fail`)",
        "pytest",
        lambda c: c["median"] > 1.1,
    ),
    ("the same, mean > +10 %", "pytest", lambda cell: cell["mean"] > 1.1),
    ("the same, median > +3 %, the gate's threshold", "pytest", lambda cell: cell["median"] > 1.03),
)
"""What stands in the table: a rule, the trials it looks at, and what it says of a cell."""

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
"""A load average up to here when a trial starts is what the trials themselves cause."""


def report(trials: list[dict[str, Any]]) -> str:
    """A table for a quiet machine and one for a loaded one, as far as there are trials."""
    quiet = [trial for trial in trials if trial["load"] <= QUIET_LOAD]
    loaded = [trial for trial in trials if trial["load"] > QUIET_LOAD]
    named = {"Quiet machine": quiet, "Loaded machine": loaded}
    return "\n\n".join(f"### {name}\n\n{summary(part)}" for name, part in named.items() if part)


def summary(trials: list[dict[str, Any]]) -> str:
    """False alarms and finds of each rule, and how long each takes."""
    rows = []
    for title, by, says in RULES:
        told = {
            name: [_told(trial, says) for trial in trials if trial["by"] == by and trial["tree"] == name]
            for name in ("same", *SLOWER)
        }
        alarms = sum(any(cells) for cells in told["same"])
        cells = [found for trial in told["same"] for found in trial]
        finds = [_share([found for trial in told[name] for found in trial]) for name in SLOWER]
        seconds = median([t["seconds"] for t in trials if t["by"] == by and t["tree"] == "same"] or [0.0])
        asked = sum(bool(trial) for trial in told["same"])
        rows.append(
            [title, str(asked), str(alarms), f"{sum(cells)} of {len(cells)}", *finds, f"{seconds:.0f}"]
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


def _told(trial: dict[str, Any], says: Says) -> list[bool]:
    # Instructions are not counted in every trial: None says nothing.
    return [bool(found) for cell in trial["cells"].values() if (found := says(cell)) is not None]


def _share(found: list[bool]) -> str:
    return f"{sum(found) / len(found):.0%} of {len(found)}" if found else "–"


if __name__ == "__main__":
    print(report([json.loads(line) for line in Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()]))
