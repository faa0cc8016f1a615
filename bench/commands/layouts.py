"""``thrustbench layouts``."""

from pathlib import Path

import click

from bench.commands import PATH, unread_output


@click.command()
@click.argument("study", type=PATH, metavar="STUDY.yaml")
@click.option("--out", required=True, type=PATH, metavar="DIR", help="Made if missing.")
@click.option("--n", type=click.IntRange(1, 2**30), help="Layouts to draw; else the study's own number.")
@click.option("--scheduler", metavar="ADDRESS", help="Of a Dask scheduler, as tcp://10.0.0.1:8786.")
@click.option("--workers", type=click.IntRange(1), help="Processes on this machine [one a core].")
@click.option("--resume", is_flag=True, help="Work out the shards that the folder lacks.")
@unread_output()
def command(
    study: Path, out: Path, n: int | None, scheduler: str | None, workers: int | None, resume: bool
) -> None:
    """Compare many layouts of a vehicle, on this machine or on many.

    Writes shards (Parquet), a report, the Pareto front, and the best layouts as vehicle files.
    docs/layouts.md says how to write a study.
    """
    import os

    from rich.console import Console

    from bench.fleet.cluster import cluster, run_all, wait_for_workers
    from bench.layouts.compile import compile_study
    from bench.layouts.measure import numbers
    from bench.layouts.report import render_study
    from bench.layouts.run import bar, check_constraints, check_folder, count_layouts, run_study
    from bench.layouts.shards import check_installed, compute, source_digest
    from bench.layouts.spaces import single_layout
    from bench.layouts.study import read_study
    from bench.report.terminal import tell

    if scheduler is not None and workers is not None:
        raise click.UsageError("--workers is of this machine; with --scheduler, start workers there")
    check_installed()
    document = read_study(study)
    space, base = compile_study(document)
    count = count_layouts(document, space, n)
    check_constraints(space, document.keys, count)
    check_folder(out, space, document.keys, count, resume=resume)
    console = Console()
    for line in space.notes:
        tell(console, line)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    with cluster(scheduler, workers or cores or 1) as client:
        console.print(f"Dask's dashboard: {client.dashboard_link}", highlight=False, soft_wrap=True)
        wait_for_workers(client)
        with bar(console) as watch:
            run_study(
                space,
                document.keys,
                count,
                out,
                lambda tasks: run_all(client, compute, tasks, space, source_digest()),
                resume=resume,
                watch=watch,
            )
    own = numbers(single_layout(base), space.dof, space.taus, space.scale, space.volume)[1]
    tell(console, f"Report: {render_study(space, own, out)}")
