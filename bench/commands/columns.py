"""``thrustbench columns``."""

import click


@click.command()
def command() -> None:
    """Say what each column of results.csv means, as Markdown."""
    from bench.results.table import documentation

    click.echo(documentation(), nl=False)
