"""``thrustbench fleet``."""

from pathlib import Path

import click

from bench.commands import PATH, RUNS, Finite, unread_output


@click.command(context_settings={"ignore_unknown_options": True})
@click.option("--scheduler", required=True, metavar="ADDRESS", help="As tcp://10.0.0.1:8786.")
@click.option("--out", type=PATH, default=RUNS, show_default=True, metavar="DIR", help="A folder a machine.")
@click.option(
    "--limit", type=Finite(1), default=7200.0, show_default=True, metavar="S", help="Longest run of a host."
)
@click.argument("options", nargs=-1, type=click.UNPROCESSED, metavar="[OPTIONS OF RUN]")
@click.pass_context
@unread_output()
def command(ctx: click.Context, scheduler: str, out: Path, limit: float, options: tuple[str, ...]) -> int:
    """Measure several computers: the workers of a Dask scheduler.

    Each host runs `thrustbench run` on itself, one run at a time. Its record comes back into a folder named
    after its machine. Files that the options name travel along. Exit code 1 where an answer is wrong, 3 where
    a host sent no record.
    """
    from rich.console import Console

    from bench.fleet.cluster import cluster, wait_for_workers
    from bench.fleet.lead import folders, hosts, keep, pack, run_fleet
    from bench.record import read
    from bench.report import render
    from bench.report.terminal import KEPT, objections, tell
    from bench.results.rows import read_run
    from bench.results.text import plural

    _check(ctx, options)
    parcel = pack(options)
    console = Console()
    with cluster(scheduler, workers=0) as client:
        wait_for_workers(client)
        fleet = hosts(client)
        console.print(
            f"{plural(len(fleet), 'host')}: {', '.join(host.host for host in fleet)}", highlight=False
        )
        with console.status("") as status:
            back = list(run_fleet(client, fleet, parcel, limit, status.update))
    back.sort()
    good = [(host, run) for host, run in back if not run.reason]
    kept = [out / name for name in folders(good)]
    for (_, run), folder in zip(good, kept, strict=True):
        if keep(run, folder):
            tell(console, KEPT.format(folder=folder))
        tell(console, f"Report: {render(folder)}")
        for line in objections(read_run(folder).rows) if run.code else ():
            tell(console, line, style="red")
    # Each host reads the same logs.
    for line in dict.fromkeys(line for folder in kept for line in read(folder).notes):
        tell(console, line)
    if len(kept) > 1:
        together = render(*kept, out=out / "fleet")
        tell(console, f"Side by side: {together}")
    for host, run in back:
        if run.reason:
            tell(console, f"{host.host}: {run.reason}")
    if len(good) < len(back):
        return 3
    return max((run.code for _, run in good), default=3)


def _check(ctx: click.Context, options: tuple[str, ...]) -> None:
    """Raise UsageError for options that `run` would refuse, before anything is sent."""
    group = ctx.parent.command if ctx.parent else None
    run = group.get_command(ctx, "run") if isinstance(group, click.Group) else None
    if run is None:
        return
    given = run.make_context("thrustbench fleet", list(options), resilient_parsing=False).params
    for option in ("out", "resume"):
        if given.get(option):
            raise click.UsageError(f"--{option} of run is no option of a fleet; each host starts afresh")
