"""One file, one command: each has ``command``, a click command, and imports what it needs when called."""

from math import isfinite
from pathlib import Path
from typing import Any

import click

PATH = click.Path(readable=False, path_type=Path)
"""A path as it was given. It need not be readable, since some files are only written; whoever opens the file
says what is wrong."""

RUNS = Path("runs")
"""Where runs go unless --out says otherwise. git ignores it; `make keep` packs a run into results/."""


class Finite(click.FloatRange):
    """A range of numbers that has neither infinity nor NaN, which click's comparisons let through."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number; a usage error where it is none, or not in the range."""
        number = float(super().convert(value, param, ctx))
        if not isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number
