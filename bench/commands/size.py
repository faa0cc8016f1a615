"""``thrustbench size``."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from bench.commands import PATH, Finite, echo, latest_run

if TYPE_CHECKING:
    from bench.results.machines import NamedRun


@click.command()
@click.argument("directories", type=PATH, nargs=-1, metavar="[DIRECTORY]...")
@click.option(
    "--rate", type=Finite(0, min_open=True), metavar="HZ", help="Of control; left out, that of the run's log."
)
@click.option(
    "--budget",
    type=Finite(0, 100, min_open=True),
    default=10.0,
    show_default=True,
    metavar="PERCENT",
    help="Share of the control period that allocation may take.",
)
@click.option(
    "--deadline-us",
    type=Finite(0, min_open=True),
    metavar="US",
    help="Time that one call may take, in place of a budget.",
)
@click.option("--vehicle", "vehicles", multiple=True, metavar="V", help="Only these of the run's vehicles.")
@click.option("--machine", "names", multiple=True, metavar="M", help="Only these of several machines.")
@click.option("--demands", default="", metavar="D", help="Only this demand set; all, if not given.")
@click.option(
    "--canary",
    type=PATH,
    metavar="FILE",
    help="Estimate for the machine on which `thrustbench canary` wrote FILE.",
)
@click.option(
    "--clock",
    "clock_MHz",
    type=Finite(0, min_open=True),
    metavar="MHZ",
    help="Clock of the processors that `thrustbench emulate` counted for.",
)
@click.option(
    "--cpi",
    type=Finite(0, min_open=True),
    nargs=2,
    metavar="LOW HIGH",
    help="Cycles an instruction there, if you measured them.",
)
@click.option(
    "--board", default="", metavar="BOARD", help="A board of such a processor: its clock, its flash included."
)
@click.option("--all", "every", is_flag=True, help="Every start and level, not only each method's best.")
def command(
    directories: tuple[Path, ...],
    rate: float | None,
    budget: float,
    deadline_us: float | None,
    vehicles: tuple[str, ...],
    names: tuple[str, ...],
    demands: str,
    canary: Path | None,
    every: bool,
    clock_MHz: float | None,
    cpi: tuple[float, float] | None,
    board: str,
) -> None:
    """Say which method fits a control rate.

    A vehicle's first row is the method to take. Without a DIRECTORY it is the latest run under runs/. Given
    the folders of several machines it says what fits on all of them, then what fits on each.
    """
    from bench.record.file import read_canary
    from bench.report.sizes import board_page, counts_page, known_boards, page
    from bench.results.emulated import Cpi
    from bench.results.machines import machine_sizes, read_machines
    from bench.results.size import Loop
    from bench.results.sizing import sizes, transfer

    if cpi is not None and cpi[0] > cpi[1]:
        raise click.UsageError(f"--cpi {cpi[0]:g} {cpi[1]:g}: give the lower number first")
    if board and (clock_MHz or cpi):
        raise click.UsageError("--board has a clock and cycles of its own; leave out --clock and --cpi")
    directories = directories or (latest_run(),)
    if len(directories) > 1 and (canary or demands):
        raise click.UsageError("--canary and --demands are for one run; give one folder")
    machines = read_machines(directories)
    timed = [machine for machine in machines if machine.run.by_vehicle]
    where = ", ".join(map(str, directories))
    if canary and not timed:
        raise click.UsageError("--canary transfers times to another machine; no method was timed here")
    measured = {name for machine in timed for name in machine.run.by_vehicle}
    counted = {kernel.vehicle for machine in machines for kernel in machine.run.record.emulated}
    _known(where, "vehicle", vehicles, measured | counted)
    sets = {row.demands for machine in timed for rows in machine.run.by_vehicle.values() for row in rows}
    _known(where, "demand set", (demands,) if demands else (), sets)
    given = None if cpi is None else Cpi(*cpi, "as given")
    loop = Loop(rate or _own_rate(machines), budget / 100, deadline_us)
    if loop.limit_us > loop.period_us:
        raise click.UsageError(
            f"--deadline-us {deadline_us:g}: is longer than the period of {loop.rate_hz:g} Hz,"
            f" {loop.period_us:g} µs; give less"
        )
    on_boards = [machine for machine in machines if board in known_boards(machine.run)]
    pages = [board_page(one.run, loop, board, vehicles) for one in on_boards or machines] if board else []
    moved = None
    if len(directories) > 1:
        sized = machine_sizes(machines, loop, clock_MHz and clock_MHz * 1e6, given)
    else:
        moved = transfer(timed[0].run, read_canary(canary)) if canary and timed else None
        sized = {machine.name: sizes(machine.run, loop, moved, demands) for machine in timed}
    _known(where, "machine", names, set(sized))
    sized = {name: own for name, own in sized.items() if not names or name in names}
    shown = {
        name: [size for size in own if not vehicles or size.vehicle in vehicles]
        for name, own in sized.items()
    }
    if any(shown.values()):
        trusted = [machine for machine in timed if machine.name in shown]
        echo(page(trusted, {name: own for name, own in shown.items() if own}, loop, moved, every))
    elif not any(machine.run.record.emulated for machine in machines):
        raise click.UsageError(
            f"{where}: no method was timed or counted there; give the folder of another run"
        )
    for machine in machines:
        if not board and (machine.run.record.emulated or (clock_MHz and not counted)):
            echo(counts_page(machine.run, loop, clock_MHz, given, vehicles))
    for text in pages:
        echo(text)


def _own_rate(machines: "Sequence[NamedRun]") -> float:
    from bench.report.verdict import log_rate_hz

    if (rate_hz := log_rate_hz(*(machine.run for machine in machines))) is None:
        raise click.UsageError("--rate HZ: no log with a rate of its own is in this run; give one")
    return rate_hz


def _known(where: str, what: str, asked: tuple[str, ...], known: set[str]) -> None:
    from alloc.errors import UnknownName

    unknown = sorted(set(asked) - known)
    if unknown:
        raise UnknownName(
            f"{where}: no {what} '{unknown[0]}' here; there is {', '.join(sorted(known)) or 'none'}"
        )
