"""``thrustbench export``."""

from pathlib import Path

import click

from bench.commands import PATH, echo, unread_output


@click.command()
@click.argument("vehicle", required=False)
@click.option("--format", "format_", metavar="F", help="csv, ros, px4 or ardusub-matrix.")
@click.option("-o", "--output", type=PATH, help="File [standard output].")
@click.option("--problems", is_flag=True, help="Problems of all shipped vehicles, with proven answers.")
@click.option("--out", type=PATH, metavar="DIR", help="Folder of the problems; made if missing.")
@click.option("--n", type=click.IntRange(1, 1000), help="Demands of each sequence [50].")
@unread_output()
def command(
    vehicle: str | None,
    format_: str | None,
    output: Path | None,
    problems: bool,
    out: Path | None,
    n: int | None,
) -> None:
    """Write a vehicle for other programs and autopilots, or problems.

    `export VEHICLE --format F` writes a vehicle: csv is T, ros parameters of ROS 2, px4 parameters of its
    geometry, ardusub-matrix factors for a firmware of your own (docs/autopilot.md).

    `export --problems --out DIR` writes the problems of all vehicles and demand sets as JSON lines, as
    Parquet and as a test set of qpbenchmark (docs/problems.md).
    """
    if problems:
        if vehicle or format_ or output or out is None:
            raise click.UsageError("--problems takes --out DIR and no vehicle, --format or -o")
        _problems(out, n)
        return
    if vehicle is None or format_ is None or out or n:
        raise click.UsageError("give VEHICLE --format F, or --problems --out DIR")
    _vehicle(vehicle, format_, output)


def _problems(out: Path, n: int | None) -> None:
    from bench.demands.problems import (
        COUNT,
        check_installed,
        problems,
        sequences,
        vehicles,
        write_problems,
    )

    check_installed()
    out.mkdir(parents=True, exist_ok=True)
    names = sequences()
    found = [problem for vehicle in vehicles() for problem in problems(vehicle, names, n or COUNT)]
    write_problems(out, found)
    none = sum(problem.f is None for problem in found)
    echo(f"{out}: {len(found):,} problems, {none:,} of them infeasible")


def _vehicle(vehicle: str, format_: str, output: Path | None) -> None:
    from alloc.errors import UnknownName
    from alloc.files.textfile import write_text
    from alloc.vehicle.azimuth import refuse_azimuths
    from alloc.vehicle.file import build_document, find_file, read_document
    from bench.inputs.formats import formats, lost_keys, writable

    if format_ not in writable():
        raise UnknownName(f"can't write format '{format_}'; there are {', '.join(writable())}")
    document = read_document(find_file(vehicle))
    keys, made = document.keys, build_document(document, vehicle)
    refuse_azimuths(made.azimuths, f"--format {format_}", "it has no place for them")
    text = formats()[format_].write(keys, made)
    if output is None:
        echo(text, nl=False)
    else:
        write_text(output, text)
    if lost := lost_keys(format_, keys):
        echo(f"{keys.name}: {format_} has no place for {', '.join(lost)}: left out", err=True)
