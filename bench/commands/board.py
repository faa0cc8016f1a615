"""``thrustbench board``."""

from pathlib import Path
from typing import Literal

import click

from bench.commands import FAULTS, LIMITS, PATH, SINGLE, echo, unread_output


@click.command()
@click.option("--vehicle", metavar="V", help="A shipped name or a YAML file.")
@click.option("--method", "methods", multiple=True, metavar="M", help="A method that has C, or esc [all].")
@click.option("--demands", multiple=True, metavar="D", help="A demand set's name [one a class, a mission].")
@SINGLE
@LIMITS
@FAULTS
@click.option("--n", type=click.IntRange(1), default=200, show_default=True, help="Demands of each set.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the demands.")
@click.option("--read", "log", type=PATH, metavar="LOG", help="Make a record of what a board printed.")
@click.option("--name", default="", help="Name of the board, with --read [its processor's].")
@click.option("--out", required=True, type=PATH, metavar="DIR", help="Made if missing.")
@unread_output()
def command(
    vehicle: str | None,
    methods: tuple[str, ...],
    demands: tuple[str, ...],
    single: bool,
    limits: Literal["fixed", "call"],
    faults: Literal["none", "one", "all"],
    n: int,
    seed: int,
    log: Path | None,
    name: str,
    out: Path,
) -> int:
    """Write C99 that times methods on a board, or read its log.

    With --read LOG it makes a record of what the board printed. Else `make` in DIR builds the C for this
    computer; its Makefile says what else. A record is rendered at once, and `thrustbench report` and `size`
    take it like any other run. Exit code 1 where an answer of this project's C is wrong, 2 where nothing in
    LOG can be used.
    """
    if (vehicle is None) == (log is None):
        raise click.UsageError("give --vehicle V to write a project, or --read LOG to make a record of a log")
    if log is not None:
        return _read(log, out, name)
    assert vehicle is not None
    from alloc.vehicle.file import load_fixed_vehicle
    from bench.chips import esc, kernels
    from bench.chips.board.project import plan, write
    from bench.chips.study import CLASSES
    from bench.results.text import cut_note, plural

    scalar: Literal["double", "float"] = "float" if single else "double"
    asked = load_fixed_vehicle(vehicle)
    wanted = kernels.as_c(methods) or (*kernels.methods(), *[esc.METHOD] * bool(asked.esc))
    project = plan(asked, wanted, demands or CLASSES, scalar, limits, n, seed, faults)
    write(project, out)
    for demands_of in project.sets:
        for line in demands_of.notes:
            echo(line)
        if demands_of.left_out:
            echo(cut_note(demands_of.name, len(demands_of.taus), demands_of.left_out))
    for reason in project.omissions:
        echo(f"left out: {reason}")
    sets = len(project.sets) + len(project.thrusts)
    said = f"{plural(len(project.kernels), 'method')}, {plural(sets, 'demand set')}"
    echo(f"{out}: {said}; `make` builds it")
    return 0


def _read(log: Path, out: Path, name: str) -> int:
    from bench.chips.board.record import keep
    from bench.report import render

    kept = keep(log, out, name)
    for line in kept.lines:
        echo(line)
    for folder in kept.folders:
        echo(f"Report: {render(folder)}")
    return 0 if kept.good else 1
