"""``thrustbench columns``."""

import click


@click.command()
def command() -> None:
    """What each column of results.csv means, as a Markdown table."""
    from bench.results.table import documentation

    click.echo(documentation(), nl=False)
