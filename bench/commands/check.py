"""``thrustbench check``."""

from pathlib import Path

import click

from bench.commands import PATH

TITLE = "drawn by thrustbench check"
"""Title of its pictures, by which a picture of its own is told from any other file."""


@click.command()
@click.argument("vehicle", metavar="VEHICLE.yaml")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of a table; no picture.")
@click.option("--picture", type=PATH, metavar="FILE", help="An .svg or .png [<vehicle>.svg, here].")
@click.option("--no-picture", is_flag=True, help="Draw nothing.")
def command(vehicle: str, as_json: bool, picture: Path | None, no_picture: bool) -> int:
    """Lint a vehicle file: errors (exit code 2), warnings, what each failure costs; and draw it."""
    from alloc.lint.check import check_vehicle
    from alloc.lint.text import as_table, to_json

    if picture is not None and picture.suffix.lower() not in (".svg", ".png"):
        raise click.UsageError(f"--picture {picture}: name a file that ends in .svg or .png")
    report = check_vehicle(vehicle)
    click.echo(to_json(report) if as_json else as_table(report))
    if report.facts is not None and (picture or not (as_json or no_picture)):
        click.echo(_drawn(report.path, picture), err=as_json)
    errors = [finding for finding in report.findings if finding.level == "error"]
    if errors:
        place = f"line {errors[0].line}: " if errors[0].line else ""
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        file = str(report.path).replace("\n", " ")
        click.echo(f"thrustbench: {file}: {place}{errors[0].message}{more}", err=True)
        return 2
    return 0


def _drawn(file: Path, picture: Path | None) -> str:
    """Draw the vehicle of a file that has no error in T or limits; a line that says where it is.

    Without a name it goes into the current folder, where it replaces nothing but an older one of its kind.
    """
    import matplotlib as mpl

    from alloc.errors import FileError
    from alloc.files.textfile import read_text
    from alloc.vehicle.file import matrices, vehicle_with
    from alloc.vehicle.poses import poses
    from alloc.vehicle.read import read_document
    from bench.report.pictures.sketch import sketch
    from bench.report.pictures.style import SETTINGS, save

    target = picture or Path(f"{file.stem}.svg")
    if picture is None and target.exists() and TITLE not in read_text(target):
        return f"{target}: is another file, so nothing is drawn; --picture names a place"
    keys = read_document(file).keys
    T, _ = matrices(keys)
    with mpl.rc_context(SETTINGS):
        figure = sketch(vehicle_with(keys, T), poses(keys, T))
        try:
            if target.suffix.lower() == ".png":
                figure.savefig(target, dpi=150)
            else:
                save(figure, target, TITLE)
        except OSError as error:
            if picture is None:
                return f"{target}: not drawn ({error.strerror}); --picture names another place"
            raise FileError(f"can't be written ({error.strerror}); name another place", path=target) from None
    return f"{target}: drawn from three sides; arrows show which way positive thrust pushes"
