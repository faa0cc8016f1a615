"""``thrustbench export``."""

from pathlib import Path

import click

from bench.commands import PATH, echo


@click.command()
@click.argument("vehicle")
@click.option("--format", "format_", required=True, metavar="F", help="csv or ros.")
@click.option("-o", "--output", type=PATH, help="File [standard output].")
def command(vehicle: str, format_: str, output: Path | None) -> None:
    """Write a vehicle as a CSV of T or as ROS 2 parameters."""
    from alloc.errors import UnknownName
    from alloc.files.textfile import write_text
    from alloc.vehicle.file import build_vehicle, find_file, read_document
    from bench.inputs.formats import formats, lost_keys, writable

    if format_ not in writable():
        raise UnknownName(f"can't write format '{format_}'; there are {', '.join(writable())}")
    keys = read_document(find_file(vehicle)).keys
    text = formats()[format_].write(keys, build_vehicle(keys))
    if output is None:
        echo(text, nl=False)
    else:
        write_text(output, text)
    if lost := lost_keys(format_, keys):
        echo(f"{keys.name}: {format_} has no place for {', '.join(lost)}: left out", err=True)
