"""``thrustbench allocate``."""

from pathlib import Path

import click

from bench.commands import PATH


@click.command()
@click.argument("demands", type=PATH)
@click.option("--vehicle", required=True, metavar="V", help="A shipped name or a YAML file.")
@click.option("--method", required=True, metavar="M", help="As `thrustbench list` names it.")
@click.option("--fault", "faults", multiple=True, metavar="I[@P]", help="Thruster I off, or at readiness P.")
@click.option("--start", default="", metavar="S", help="cold, reused or warm.")
@click.option("--level", default="", metavar="L", help="default or tight.")
@click.option("--plugin", type=PATH, help="Python file that holds the method.")
@click.option("-o", "--output", type=PATH, help="Thrust CSV [standard output].")
def command(
    demands: Path,
    vehicle: str,
    method: str,
    faults: tuple[str, ...],
    start: str,
    level: str,
    plugin: Path | None,
    output: Path | None,
) -> None:
    """Thrusts for the demands in a CSV file: a header with the DOF names, one row a demand.

    Writes status,f0,f1,… with one row a demand, in order, in N; then share0,share1,… where a method says
    what it delivered of each level of the demand. Where a method says that there is no such thrust, its
    numbers are nan.
    """
    from alloc import UnknownName, find, load_plugin, load_vehicle, prepare
    from alloc.files.textfile import write_text
    from bench.inputs.demand_csv import format_thrusts, read_demands
    from bench.inputs.faults import with_fault

    answering = load_vehicle(vehicle)
    for fault in faults:
        answering = with_fault(answering, fault)
    entry = load_plugin(plugin) if plugin else find(method)
    if entry.name != method:
        raise UnknownName(
            f"{plugin}: holds method '{entry.name}', not '{method}'; give --method {entry.name}"
        )
    _, taus = read_demands(demands, answering.dof)
    allocator = prepare(entry, answering, start=start, level=level)
    text = format_thrusts([allocator(tau) for tau in taus])
    if output is None:
        click.echo(text, nl=False)
    else:
        write_text(output, text)
