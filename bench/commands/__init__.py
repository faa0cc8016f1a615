"""One file, one command: each has ``command``, a click command, and imports what it needs when called."""

from math import isfinite
from typing import Any

import click


class Finite(click.FloatRange):
    """A range of numbers without NaN, which no comparison keeps out, and without infinity."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number; a usage error where it is none, or not in the range."""
        number = float(super().convert(value, param, ctx))
        if not isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number
