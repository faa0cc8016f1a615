"""``thrustbench report``."""

from pathlib import Path

import click

from bench.commands import PATH


@click.command()
@click.argument("directory", type=PATH)
@click.option(
    "--readme",
    type=PATH,
    metavar="FILE",
    help="Also put the result table between the markers of this file.",
)
def command(directory: Path, readme: Path | None) -> None:
    """Render results.csv, report.md and report.html of a run from the record in DIRECTORY."""
    from bench.report import render
    from bench.report.readme import put, result_table
    from bench.results.rows import read_run

    click.echo(str(render(directory)))
    if readme:
        put(readme, result_table(read_run(directory)))
        click.echo(str(readme))
