"""``thrustbench report``."""

from pathlib import Path

import click


@click.command()
@click.argument("directory", type=click.Path(path_type=Path))
def command(directory: Path) -> None:
    """Render results.csv and report.md of a run from the record in DIRECTORY."""
    from bench.report import render

    click.echo(str(render(directory)))
