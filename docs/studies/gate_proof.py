"""How often the gate raises false alarms and what it finds, beside two runs of pytest-benchmark.

    python docs/studies/gate_proof.py FILE --minutes 30    measure, one line a trial
    python docs/studies/gate_table.py FILE                 the table of results/studies/gate_table.md

A trial compares the tree with a copy of itself or with a copy whose calls do 5, 10 or 20 % more work, by the
gate or by two runs of pytest-benchmark. All kinds of trials take turns, so that they meet the same machine in
the same hour, and so that a run that is stopped leaves a balanced file. The next run continues the file.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from itertools import count
from pathlib import Path
from statistics import fmean
from time import monotonic
from typing import Any

import click

from bench.gate.record import DEFAULT_CELLS, GateRecord, GateSettings
from bench.gate.run import compare
from bench.gate.trees import SourceTree
from bench.gate.verdict import Standing, is_slower, row, trips, verdict
from bench.suite.compare import compare as compare_benchmarks
from bench.suite.compare import read
from gate_table import SLOWER
from injection import CLOSED_FORMS, QP_PATHS, slow_down

ROOT = Path(__file__).parents[2]
CALIBRATED = {
    CLOSED_FORMS: ("ukwial:pinv:-", "ukwial:svd:-", "ukwial:walsh:-"),
    QP_PATHS: ("ukwial:qp/daqp:reused",),
}
"""By class that is slowed down, the cells that the per cent hold for. Identical trees are compared on the
gate's default cells."""
CELLS = tuple(cell for cells in CALIBRATED.values() for cell in cells)
TUNING = (20, 300)
"""Added statements of the two trees from which the cost of a statement is worked out."""
CORRECTIONS = 2
"""Number of corrections of the count of statements by the slow-down that the gate measures."""
SETTINGS = GateSettings(budget_s=600.0)
COUNT_EVERY = 5
"""Instruction counts hardly vary, so not every trial takes them."""
RULE = "median:10%"
"""The usual rule, given to ``--benchmark-compare-fail``."""


def prepare(folder: Path, slower: Sequence[str]) -> dict[str, SourceTree]:
    """The tree, a copy of it, and the slower copies, calibrated on this machine."""
    trees = {name: SourceTree(folder / name) for name in ("base", "same", *slower)}
    ignore = shutil.ignore_patterns("__pycache__", ".*")
    for tree in trees.values():
        for part in ("alloc", "bench"):
            shutil.copytree(ROOT / part, tree.path / part, ignore=ignore)
    for where, cells in CALIBRATED.items() if slower else ():
        calibrate(trees, where, cells)
    for tree in trees.values():
        subprocess.run([tree.python, "-m", "compileall", "-q", str(tree.path)], check=True)
    return trees


def calibrate(trees: dict[str, SourceTree], where: tuple[str, str], cells: Sequence[str]) -> None:
    """Make calls of a class take the given per cent more in each slower tree, as the gate measures it.

    The cost of a statement depends on the code around it, so it is measured in that place: by two numbers of
    statements, and then by corrections of what is still missing.
    """

    def excess(name: str, statements: int) -> float:
        shutil.copy(trees["base"].path / where[0], trees[name].path / where[0])
        slow_down(trees[name].path, where, statements)
        rows = rows_of(gated(trees["base"], trees[name], cells, GateSettings(pairs=20, budget_s=600.0)))
        return fmean(rows[cell].ratio.value for cell in cells) - 1

    few, many = TUNING
    excess_few, excess_many = (excess("up20", n) for n in TUNING)
    each = (excess_many - excess_few) / (many - few)
    click.echo(f"{where[1]}: a statement more takes {each:.3%} of a call")
    for name, percent in SLOWER.items():
        statements, measured = few, excess_few
        for _ in range(1 + CORRECTIONS):
            statements = max(1, statements + round((percent / 100 - measured) / each))
            measured = excess(name, statements)
        click.echo(f"{where[1]}: {statements} statements take {measured:.1%}, asked for {percent} %")


def gated(
    base: SourceTree,
    head: SourceTree,
    cells: Sequence[str],
    settings: GateSettings = SETTINGS,
    count: bool = False,
) -> GateRecord:
    """One gate between two trees that are ready to run."""
    record = GateRecord(base=base.path.name, head=head.path.name, settings=settings)
    compare(record, (base, head), cells, count=count)
    return record


def rows_of(record: GateRecord) -> dict[str, Standing]:
    """The timed cells by name."""
    return {cell.name: row(cell, record.settings) for cell in record.cells if cell.pairs}


def by_gate(name: str, trees: dict[str, SourceTree], counted: bool) -> dict[str, Any]:
    """One gate of the tree against ``name``: its outcome, and each cell's ratio and verdict."""
    record = gated(trees["base"], trees[name], DEFAULT_CELLS if name == "same" else CELLS, count=counted)
    rows, cells = rows_of(record), {}
    for cell in record.cells:
        if cell.name not in rows or cell.is_control:
            continue
        confirmed = len(cell.pairs) >= 2 * record.settings.pairs
        cells[cell.name] = {
            "ratio": round(rows[cell.name].ratio.value, 4),
            "time": confirmed and is_slower(rows[cell.name]),
        }
        if cell.instructions:
            cells[cell.name]["trips"] = len(cell.instructions) > 1 and all(map(trips, cell.instructions))
    return {"outcome": verdict(record).outcome.name.lower(), "cells": cells}


def by_pytest(name: str, trees: dict[str, SourceTree], _: bool) -> dict[str, Any]:
    """Two runs of the suite, one after the other, of which the second fails above +10 %."""
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / f"{side}.json" for side in ("a", "b")]
        storage = ["--benchmark-storage", f"file://{folder}/kept"]
        first = [*storage, "--benchmark-save=base"]
        second = [*storage, "--benchmark-compare=0001", f"--benchmark-compare-fail={RULE}"]
        for tree, out, options in zip((trees["base"], trees[name]), files, (first, second), strict=True):
            methods = [f"--method={cell.split(':')[1]}" for cell in CELLS]
            arguments = ["bench/suite/test_call.py", "--benchmark-only", "--vehicle=ukwial", *methods]
            selection = [
                "-k",
                "inactive and not cold and not warm",
                f"--benchmark-json={out}",
                "-q",
                *options,
            ]
            command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments, *selection]
            done = subprocess.run(command, cwd=tree.path, capture_output=True, text=True)
            if not out.exists():
                raise RuntimeError(done.stdout + done.stderr)
        compared = compare_benchmarks(*map(read, files))
        means = [
            {b["name"]: b["stats"]["mean"] for b in json.loads(file.read_text())["benchmarks"]}
            for file in files
        ]
    cells = {r.name.partition("::")[2]: {"median": round(r.median_ratio, 4)} for r in compared.ratios}
    for cell in cells:
        cells[cell]["mean"] = round(means[1][cell] / means[0][cell], 4)
    return {"outcome": "regression" if done.returncode else "pass", "cells": cells}


Trial = tuple[str, str, Callable[[str, dict[str, SourceTree], bool], dict[str, Any]]]

SAME: Trial = ("gate", "same", by_gate)
TURN: tuple[Trial, ...] = (
    *(trial for name in SLOWER for trial in (SAME, SAME, ("gate", name, by_gate))),
    SAME,
    *(("pytest", name, by_pytest) for name in ("same", *SLOWER)),
)
"""One turn of trials. Identical trees come most often, because rare false alarms need many trials."""


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--minutes", type=float, default=60.0, show_default=True)
@click.option("--identical", is_flag=True, help="Gates between identical trees only, by time alone.")
def main(file: Path, minutes: float, identical: bool) -> None:
    """Append a line for each trial to FILE until the time is over, continuing where FILE ends."""
    deadline = monotonic() + 60 * minutes
    done = len(file.read_text(encoding="utf-8").splitlines()) if file.exists() else 0
    with tempfile.TemporaryDirectory(prefix="gate-proof-") as folder:
        trees = prepare(Path(folder), () if identical else tuple(SLOWER))
        for i in count(done):
            if monotonic() > deadline:
                break
            by, name, trial = SAME if identical else TURN[i % len(TURN)]
            started, load = monotonic(), os.getloadavg()[0]
            result = trial(name, trees, not identical and i % COUNT_EVERY == 0)
            seconds = round(monotonic() - started, 1)
            line = {"by": by, "tree": name, "load": round(load, 2), "seconds": seconds, **result}
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps(line) + "\n")


if __name__ == "__main__":
    main()
