"""Whether the gate sees answers that became wrong in one demand of a thousand.

``python docs/studies/gate_answers.py``: each trial spoils every method of a copy of the tree, in other
demands, and asks for the verdict on each of the gate's default cells from answers alone, nothing is timed. A
thrust is off by a hundredth of the largest limit, in single calls and in ``many`` alike. Beside them
identical trees are compared, which must not raise an alarm.
"""

import shutil
import tempfile
from collections import Counter
from contextlib import closing
from pathlib import Path

import click
from tabulate import tabulate

from bench.gate.examine import examine
from bench.gate.record import DEFAULT_CELLS
from bench.gate.side import Prober
from bench.gate.trees import SourceTree
from gate_proof import prepare
from injection import spoil_answers

SHIFT = 0.01
KINDS = {"identical": None, "1 in 1000": False, "1 in 1000, active demands alone": True}


@click.command()
@click.option("--trials", default=10, show_default=True)
@click.option("--one-in", default=1000, show_default=True)
@click.option("--seed", default=0, show_default=True, help="Of the first trial.")
@click.option("--cells", default=len(DEFAULT_CELLS), show_default=True, help="How many of the default ones.")
def main(trials: int, one_in: int, seed: int, cells: int) -> None:
    """Print in how many cells the gate names an answer, of spoilt trees and of identical ones."""
    asked: Counter[str] = Counter()
    named: Counter[str] = Counter()
    missed: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="gate-answers-") as folder:
        trees = prepare(Path(folder), ())
        for trial in range(seed, seed + trials):
            for kind, active in KINDS.items():
                shutil.rmtree(trees["same"].path / "alloc")
                shutil.copytree(trees["base"].path / "alloc", trees["same"].path / "alloc")
                if active is not None:
                    spoil_answers(trees["same"].path, trial, one_in=one_in, shift=SHIFT, active=active)
                for cell, found in compared(trees["base"], trees["same"], cells).items():
                    asked[kind] += 1
                    named[kind] += bool(found)
                    if active is not None and not found:
                        missed[cell] += 1
            rows = [[kind, asked[kind], named[kind], f"{named[kind] / asked[kind]:.1%}"] for kind in KINDS]
            click.echo(tabulate(rows, ["head", "cells", "named by the gate", "share"], tablefmt="github"))
    click.echo(f"not found: {dict(missed)}")


def compared(base: SourceTree, head: SourceTree, cells: int) -> dict[str, str]:
    """Verdict of the gate on the head's answers, by cell, for so many of the default ones; or nothing."""
    with closing(Prober(base)) as one, closing(Prober(head)) as other:
        examined = examine(one, other, DEFAULT_CELLS[:cells])
    return {
        cell.name: "" if cell.base_wrong else cell.head_wrong or cell.differ or cell.head_lacks
        for cell in examined.cells
        if not cell.is_control
    }


if __name__ == "__main__":
    main()
