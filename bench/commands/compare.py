"""``thrustbench compare``."""

from pathlib import Path

import click

from bench.commands import PATH, echo


@click.command()
@click.argument("a", type=PATH)
@click.argument("b", type=PATH)
def command(a: Path, b: Path) -> None:
    """Show ratios B / A of two pytest-benchmark files.

    It informs and never fails: `thrustbench gate` says whether a commit is slower.
    """
    from tabulate import tabulate

    from bench.suite.compare import compare, read

    comparison = compare(read(a), read(b))
    for difference in comparison.machine:
        echo(f"warning: not the same machine or software: {difference}", err=True)
    for side, names in (("A", comparison.only_a), ("B", comparison.only_b)):
        for name in names:
            echo(f"only in {side}: {name}")
    if not comparison.ratios:
        echo("no benchmark stands in both files")
        return
    headers = ("benchmark", "A median [µs]", "B median [µs]", "B/A of medians", "B/A of minima")
    echo(tabulate(comparison.ratios, headers=headers, floatfmt=("", ".3f", ".3f", ".3f", ".3f")))
    echo(f"\ngeometric mean of the medians' ratios: {comparison.geometric_mean:.3f}")
    echo("Times from different runs differ without cause; 'thrustbench gate' tells whether code did it.")
