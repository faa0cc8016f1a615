"""``thrustbench emulate``."""

from pathlib import Path
from typing import Literal

import click

from bench.commands import FAULTS, PATH, RUNS, unread_output

BESIDE = ("clip", "scaled")
"""Methods that are counted beside somebody's C where none is named."""


@click.command()
@click.option(
    "--vehicle", "vehicles", multiple=True, metavar="V", help="A shipped name or a YAML file [all]."
)
@click.option("--target", "targets", multiple=True, metavar="T", help="A processor's name [all].")
@click.option(
    "--method", "methods", multiple=True, metavar="M", help="A method that has C [all], esc, monitor, cap."
)
@click.option(
    "--sources", multiple=True, metavar="C", help="An allocator of your own: its C files, 'src/*.c'."
)
@click.option("--include", multiple=True, type=PATH, metavar="DIR", help="Its headers, with --sources.")
@click.option("--interface", type=PATH, metavar="H", help="Its copy of thrustbench_allocator.h [ours].")
@click.option("--demands", multiple=True, metavar="D", help="A demand set's name [one a class, a mission].")
@click.option("--double", "scalars", flag_value="double", help="Double precision only.")
@click.option("--float", "scalars", flag_value="float", help="Single precision only.")
@click.option(
    "--limits",
    type=click.Choice(["fixed", "call"]),
    multiple=True,
    help="fixed: in the C; call: arguments of each call [both].",
)
@FAULTS
@click.option("--n", type=click.IntRange(1), default=200, show_default=True, help="Demands of each set.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of demands and search.")
@click.option("--add", is_flag=True, help="Add to the record in --out, in place of a new one.")
@click.option(
    "--out",
    type=PATH,
    default=RUNS / "emulated",
    show_default=True,
    metavar="DIR",
    help="Made if missing.",
)
@unread_output()
def command(
    vehicles: tuple[str, ...],
    targets: tuple[str, ...],
    methods: tuple[str, ...],
    sources: tuple[str, ...],
    include: tuple[Path, ...],
    interface: Path | None,
    demands: tuple[str, ...],
    scalars: str | None,
    limits: tuple[Literal["fixed", "call"], ...],
    faults: Literal["none", "one", "all"],
    n: int,
    seed: int,
    add: bool,
    out: Path,
) -> int:
    """Count instructions and memory of generated C under QEMU.

    Beside each count stands callgrind's of the same C on x86-64. Exit code 1 where this project's C does not
    answer as Python does (what solvers' does is in the report), 2 where a --target lacks its tools, or no C
    is written. `make emulate` installs what this needs. --sources counts somebody's C behind
    thrustbench_allocator.h, in the precision that it says (--float defines TBA_FLOAT), beside `clip` and
    `scaled` where no --method is given; its answers must be those of the same C on this machine.
    """
    from rich.console import Console

    from alloc import NotApplicable, list_vehicles, load_vehicle
    from alloc.errors import NotInstalled
    from bench.chips import kernels
    from bench.chips.foreign import find_sources
    from bench.chips.processors import processor, processors
    from bench.chips.study import CLASSES, Plan, write
    from bench.report import render
    from bench.results.emulated import refusal_reason

    for name in targets:
        processor(name)  # raises for one that is not known
    if (include or interface) and not sources:
        raise click.UsageError("--include and --interface are of --sources; give that too")
    foreign = find_sources(sources, include, interface, single=scalars == "float") if sources else None
    if foreign is not None:
        if scalars and scalars != foreign.scalar:
            raise click.UsageError(f"{foreign.name}: says {foreign.scalar}; leave out --{scalars}")
        methods, scalars = (foreign.name, *kernels.as_c(methods or BESIDE)), foreign.scalar
    counted = [one for one in processors() if one.callgrind or not targets or one.name in targets]
    plan = Plan(
        vehicles=tuple(load_vehicle(name) for name in vehicles or list_vehicles()),
        processors=tuple(sorted(counted, key=lambda one: one.callgrind)),
        methods=kernels.as_c(methods) or (*kernels.methods(), *kernels.prepared()),
        scalars=("double", "float") if scalars is None else ("float",) if scalars == "float" else ("double",),
        limits=limits or ("fixed", "call"),
        faults=faults,
        demands=demands or CLASSES,
        seed=seed,
        n=n,
        theirs=foreign,
    )
    console = Console(highlight=False, markup=False, soft_wrap=True)
    good = True
    rows = []
    for row in write(plan, out, add=add):
        rows.append(row)
        answered = row.agrees is not False or row.solver != ""
        good = good and answered and row.status in ("ok", "missing", "refused")
        worst = (
            f"{row.instructions[-1][0]} instructions at most, {row.flash_bytes} bytes of flash, "
            f"{row.stack_bytes} of stack"
            if row.instructions
            else row.reason
        )
        console.print(
            row.vehicle, row.target, row.method, row.scalar, row.limits, row.demands, row.status, worst
        )
    console.print(f"Report: {render(out)}")
    for name in targets:
        own = [row for row in rows if row.target == name]
        if own and all(row.status == "missing" for row in own):
            raise NotInstalled(f"nothing was counted on {name}: {own[0].reason}")
    if reason := refusal_reason(rows):
        raise NotApplicable(f"nothing was counted: {reason}")
    return 0 if good else 1
