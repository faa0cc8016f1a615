"""One file, one command: each has ``command``, a click command, and imports what it needs when called."""

from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from bench.inputs.logs import LogOptions

PATH = click.Path(readable=False, path_type=Path)
"""A path as it was given. It need not be readable, since some files are only written; whoever opens the file
says what is wrong."""

SINGLE = click.option("--float", "single", is_flag=True, help="Single precision; else double.")
LIMITS = click.option(
    "--limits",
    type=click.Choice(["fixed", "call"]),
    default="fixed",
    show_default=True,
    help="The vehicle's, in the C; or f_min and f_max, arguments of each call.",
)
"""The options of every command that writes C."""

RUNS = Path("runs")
"""Where runs go unless --out says otherwise, each into a folder of its own: ``<machine>/<date and time>``.
git ignores it; `make keep` packs a run into results/."""


def latest_run(within: Path = RUNS) -> Path:
    """The folder whose record was written last; raises RecordError where there is none."""
    from bench.record import FILE_NAME, RecordError

    records = sorted(within.rglob(FILE_NAME), key=lambda path: (path.stat().st_mtime_ns, str(path)))
    if not records:
        raise RecordError(f"{within}: holds no run; `thrustbench run` makes one, or give a run's folder")
    return records[-1].parent


def log_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options on what a log does not say itself; ``read_options`` makes the LogOptions of their values."""
    for option in (
        click.option("--scale", default="", metavar="S,…", help="Factor a DOF, of a log without newtons."),
        click.option("--columns", default="", metavar="D=C,…", help="Columns of a table: surge=fx,t=stamp."),
        click.option(
            "--frame", type=click.Choice(["frd", "flu"]), help="What the log is in, whatever it says."
        ),
        click.option("--topic", default="", metavar="T", help="Where a bag has wrenches on several."),
    ):
        command = option(command)
    return command


def read_options(topic: str, frame: str | None, columns: str, scale: str) -> "LogOptions":
    """What a user says about logs, as data."""
    from bench.inputs.columns import parse_columns
    from bench.inputs.demand_csv import parse_scale
    from bench.inputs.logs import LogOptions

    return LogOptions(
        topic=topic, frame=frame or "", columns=parse_columns(columns), scale=parse_scale(scale)
    )


class Finite(click.FloatRange):
    """A range of numbers that has neither infinity nor NaN, which click's comparisons let through."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number; a usage error where it is none, or not in the range."""
        number = float(super().convert(value, param, ctx))
        if not isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number
