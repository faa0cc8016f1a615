"""``thrustbench demands``."""

from pathlib import Path
from typing import Any

import click

from bench.commands import PATH, log_options, read_options


@click.command()
@click.argument("log", type=PATH)
@click.option("--vehicle", required=True, metavar="V", help="A shipped name or a YAML file.")
@log_options
@click.option("-o", "--output", type=PATH, help="The demands as CSV, in the vehicle's frame.")
def command(log: Path, vehicle: str, output: Path | None, **options: Any) -> None:
    """Summarise a log (CSV, ROS bag, PX4 ULog): rate, gaps, labels, what a closed form could serve."""
    from alloc import load_vehicle
    from alloc.files.textfile import write_text
    from bench.demands import labelled
    from bench.demands.doubts import doubts
    from bench.demands.log_summary import as_text, summarise
    from bench.inputs.demand_csv import format_demands
    from bench.inputs.log_limits import limits_in
    from bench.inputs.logs import rate_hz, read_log

    answering = load_vehicle(vehicle)
    read = read_log(
        log, answering.dof, read_options(**options), frame=answering.frame, thrusters=answering.names
    )
    t, taus, columns = read.t, read.taus, read.columns
    low, high = limits_in(log, columns, answering)
    demands = labelled(log.stem, answering, taus, low, high, rate_hz=rate_hz(t))
    click.echo(as_text(summarise(demands, t), demands))
    if output is not None:
        write_text(output, format_demands(t, taus, answering.dof, columns, frame=answering.frame))
    click.echo(read.said, err=True)  # at last, since a refusal is one line
    for doubt in filter(None, (read.doubt, *doubts(demands))):
        click.echo(f"warning: {doubt}", err=True)
