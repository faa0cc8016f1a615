"""``thrustbench report``."""

from pathlib import Path

import click

from bench.commands import PATH, echo, latest_run, unread_output


@click.command()
@click.argument("directories", type=PATH, nargs=-1, metavar="[DIRECTORY]...")
@click.option("-o", "--out", type=PATH, metavar="OUT", help="Folder of the report [that of the one run].")
@click.option(
    "--readme",
    type=PATH,
    metavar="FILE",
    help="Also put the result table between the markers of this file.",
)
@unread_output()
def command(directories: tuple[Path, ...], out: Path | None, readme: Path | None) -> None:
    """Render the report of a run, or one report of several machines.

    Makes results.csv, report.md, details.md and report.html of the record in DIRECTORY. Without a DIRECTORY
    it is the latest run under runs/. The runs of several machines become one report, in OUT.
    """
    from bench.report import render
    from bench.report.page import put, result_table
    from bench.results.rows import read_run

    directories = directories or (latest_run(),)
    if len(directories) > 1 and out is None:
        raise click.UsageError("several folders make one report: name its folder with -o OUT")
    echo(str(render(*directories, out=out)))
    if readme:
        put(readme, result_table(read_run(directories[0])))
        echo(str(readme))
