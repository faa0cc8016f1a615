"""``thrustbench columns``."""

import click

from bench.commands import echo


@click.command()
def command() -> None:
    """Say what each column of results.csv means, as Markdown."""
    from bench.results.columns import documentation

    echo(documentation(), nl=False)
