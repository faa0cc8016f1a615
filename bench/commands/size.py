"""``thrustbench size``."""

from pathlib import Path

import click

from bench.commands import PATH, Finite


@click.command()
@click.argument("directory", type=PATH)
@click.option("--rate", type=Finite(0, min_open=True), required=True, metavar="HZ", help="Of control.")
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
@click.option("--all", "every", is_flag=True, help="Every start and level, not only each method's best.")
def command(
    directory: Path,
    rate: float,
    budget: float,
    deadline_us: float | None,
    vehicles: tuple[str, ...],
    canary: Path | None,
    every: bool,
    clock_MHz: float | None,
    cpi: tuple[float, float] | None,
) -> None:
    """Which method of the run in DIRECTORY fits a control rate; of times, take a vehicle's first row.

    Counts of generated C are sorted by cost alone; the cheapest may know no limits.
    """
    from alloc import UnknownName
    from bench.record.canary import read_canary
    from bench.report import bands
    from bench.report.sizes import page
    from bench.results.fit import Loop
    from bench.results.rows import read_run
    from bench.results.sizing import best_of_each, canary_max_us, sizes
    from bench.results.transfer import transfer

    if cpi is not None and cpi[0] > cpi[1]:
        raise click.UsageError(f"--cpi {cpi[0]:g} {cpi[1]:g}: give the lower number first")
    run = read_run(directory)
    known = sorted({*run.vehicles, *(row.vehicle for row in run.record.emulated)})
    unknown = sorted(set(vehicles) - set(known))
    if unknown:
        raise UnknownName(f"{directory}: no vehicle '{unknown[0]}' in this run; it has {', '.join(known)}")
    loop = Loop(rate, budget / 100, deadline_us)
    if run.record.emulated or clock_MHz:
        click.echo(bands.page(run, loop, clock_MHz, cpi, vehicles))
    if not run.rows:
        return
    moved = transfer(run, read_canary(canary)) if canary else None
    shown = [size for size in sizes(run, loop, moved) if not vehicles or size.vehicle in vehicles]
    click.echo(page(shown if every else best_of_each(shown), loop, moved, canary_max_us(run)))
