"""``thrustbench run``."""

from pathlib import Path
from typing import Any

import click

from bench.commands import (
    PATH,
    RUNS,
    Finite,
    latest_run,
    log_options,
    read_options,
    unread_output,
)


@click.command()
@click.option("--vehicle", "vehicles", multiple=True, metavar="V", help="A shipped name or a YAML file.")
@click.option(
    "--method",
    "methods",
    multiple=True,
    metavar="M",
    help="As in `thrustbench list`, qp/*, a file, exec:COMMAND.",
)
@click.option("--demands", multiple=True, metavar="D", help="A set's name, a CSV, bag or ULog.")
@click.option(
    "--fault",
    "faults",
    multiple=True,
    metavar="I[@P]",
    help="Thruster I, a number or name: off, or at P; or each; a state of its own each time.",
)
@click.option(
    "--start",
    "starts",
    multiple=True,
    type=click.Choice(["cold", "reused", "warm"]),
    help="Default: reused; all where both vehicles and demands are named.",
)
@click.option(
    "--level",
    "levels",
    multiple=True,
    type=click.Choice(["default", "tight"]),
    help="Default: both for qp/*, tight for others.",
)
@log_options
@click.option(
    "--plugin",
    "plugins",
    multiple=True,
    metavar="FILE",
    help="File or exec:COMMAND with a method; alone, unless --method names others.",
)
@click.option("--repeats", type=click.IntRange(1), help="Fresh processes a method [2].")
@click.option("--seed", type=click.IntRange(0), help="Of demands and order [0].")
@click.option(
    "--n",
    "n_demands",
    type=click.IntRange(1),
    help="Demands of a set, the first of a log [60; --quick 50]; of a mission those that are timed.",
)
@click.option("--budget-ms", type=Finite(0), help="Time for the calls of a cell in one repeat [ms].")
@click.option(
    "--time-limit", "time_limit_s", type=Finite(0.1), metavar="S", help="Longest time of a cell [10 s]."
)
@click.option(
    "--memory",
    "memory_MB",
    type=click.IntRange(64, 1 << 24),
    metavar="MB",
    help="Most memory of a worker [2048].",
)
@click.option(
    "--quick",
    "preset",
    flag_value="quick",
    help="Half a minute: two vehicles, or yours, in one repeat; no soft QPs.",
)
@click.option("--all", "preset", flag_value="full", help="The full matrix: about an hour, resumable.")
@click.option("--study", type=click.Choice(["growth"]), help="growth: made-up vehicles of 4 to 64 thrusters.")
@click.option("--resume", is_flag=True, help="Go on with the record in --out, or with this machine's latest.")
@click.option(
    "--out", type=PATH, metavar="DIR", help="Of record and report [runs/<machine>/<date and time>]."
)
@unread_output()
def command(
    out: Path | None,
    preset: str | None,
    study: str | None,
    resume: bool,
    faults: tuple[str, ...],
    topic: str,
    frame: str | None,
    columns: str,
    scale: str,
    **options: Any,
) -> int:
    """Time and judge every method, and write a report.

    Each method has a process of its own. Exit code 1 where an answer is wrong or disagrees, 130 after Ctrl-C,
    with a report of what there is.
    """
    from msgspec.structs import replace
    from rich.console import Console

    from alloc.discovery import is_plugin
    from bench.harness import machine, plan
    from bench.harness.run import Interrupted, run
    from bench.harness.state import bar
    from bench.inputs.faults import parse_fault
    from bench.record import FILE_NAME, read
    from bench.report import render
    from bench.report.terminal import KEPT, show, tell

    if study and preset:
        raise click.UsageError("give one of --study, --quick and --all")
    console = Console()
    brought = tuple(filter(is_plugin, options["methods"]))
    options["methods"] = tuple(name for name in options["methods"] if name not in brought)
    options["plugins"] += brought
    options["faults"] = tuple(map(parse_fault, faults))
    options["log"] = read_options(topic, frame, columns, scale)
    settings = getattr(plan, study or preset or "default")()
    settings = replace(settings, **{key: value for key, value in options.items() if value not in (None, ())})
    if options["demands"] or options["methods"] or options["repeats"]:
        settings = replace(settings, once=())  # what a user names is repeated
    if options["vehicles"] and options["demands"] and not options["starts"]:
        settings = replace(settings, starts=("cold", "reused", "warm"))  # there is time for all
    directory = out or _folder(RUNS / machine.name(), study or "", resume)
    if not resume and (directory / FILE_NAME).exists():
        tell(console, KEPT.format(folder=directory))

    def warn(line: str) -> None:
        tell(console, f"warning: {line}", "red")

    interrupted = False
    with bar(console) as watch:
        try:
            run(settings, directory, resume=resume, watch=watch, warn=warn)
        except Interrupted:
            interrupted = True
    report = render(directory)
    for line in read(directory).notes:
        tell(console, line)
    good = show(directory, console)
    tell(console, f"Report: {report}")
    if interrupted:
        console.print(
            "Interrupted; the same command with `--resume` goes on where it stopped.", highlight=False
        )
        return 130
    return 0 if good else 1


def _folder(machine: Path, study: str, resume: bool) -> Path:
    """This machine's latest run, to be resumed; else a new folder named after the moment, and the study."""
    from itertools import chain
    from time import strftime

    if resume and any(machine.rglob("record.jsonl")):
        return latest_run(machine)
    stamp = "-".join(filter(None, (strftime("%Y-%m-%d-%H%M%S"), study)))
    again = (machine / f"{stamp}-{i}" for i in range(2, 1000))  # several in a second, as from scripts
    return next(folder for folder in chain([machine / stamp], again) if not folder.exists())
