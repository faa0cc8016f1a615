"""``thrustbench demands``."""

from pathlib import Path

import click

from bench.commands import PATH


@click.command()
@click.argument("log", type=PATH)
@click.option("--vehicle", required=True, metavar="V", help="A shipped name or a YAML file.")
@click.option("--topic", default="", metavar="T", help="Where a bag has wrenches on several.")
@click.option("--frame", type=click.Choice(["frd", "flu"]), help="Where the log's own frame is wrong.")
@click.option("--scale", default="", metavar="S,…", help="Factor a DOF, for normalised setpoints.")
@click.option("-o", "--output", type=PATH, help="The demands as CSV, z down.")
def command(log: Path, vehicle: str, topic: str, frame: str | None, scale: str, output: Path | None) -> None:
    """Summarise a log (CSV, ROS bag, PX4 ULog): rate, gaps, labels, what a closed form could serve."""
    from alloc import load_vehicle
    from alloc.files.textfile import write_text
    from bench.demands import labelled
    from bench.demands.log_summary import as_text, summarise
    from bench.inputs.demand_csv import format_demands, parse_scale
    from bench.inputs.logs import rate_hz, read_log

    answering = load_vehicle(vehicle)
    t, taus = read_log(log, answering.dof, topic, frame or "")
    taus = taus * parse_scale(scale, answering.dof)
    demands = labelled(log.stem, answering, taus, rate_hz=rate_hz(t))
    click.echo(as_text(summarise(demands, t), demands))
    if output is not None:
        write_text(output, format_demands(t, taus, answering.dof))
