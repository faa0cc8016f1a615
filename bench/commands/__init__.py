"""One file, one command: each has ``command``, a click command, and imports what it needs when called."""

from math import isfinite
from pathlib import Path
from typing import Any

import click

PATH = click.Path(readable=False, path_type=Path)
"""A path as it was given: not asked to be readable, since what is only written need not be; whoever opens it
says why it can't."""

RUNS = Path("runs")
"""Where runs go unless --out says otherwise. git ignores it; `make keep` takes one of them into results/."""


class Finite(click.FloatRange):
    """A range of numbers without NaN, which no comparison keeps out, and without infinity."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number; a usage error where it is none, or not in the range."""
        number = float(super().convert(value, param, ctx))
        if not isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number
