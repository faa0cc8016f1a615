"""``thrustbench gate``."""

from glob import escape
from pathlib import Path

import click

from bench.commands import PATH, Finite, echo

FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)

FILE = click.Path(dir_okay=False, path_type=str)  # it may be in the two sides and not here, or a command


@click.command()
@click.argument("base", required=False)
@click.argument("head", required=False)
@click.option("--base-path", type=FOLDER, help="A folder with a tree, instead of BASE.")
@click.option("--head-path", type=FOLDER, help="A folder with a tree, instead of HEAD.")
@click.option("--repo", type=FOLDER, default=".", help="The repository of BASE and HEAD; default: here.")
@click.option("--cells", multiple=True, metavar="PATTERN", help="vehicle:method:start, * and ? allowed.")
@click.option(
    "--threshold", type=Finite(min=1), default=3.0, show_default=True, help="What a cell may get slower [%]."
)
@click.option(
    "--pairs", type=click.IntRange(min=2), default=10, show_default=True, help="Pairs of processes a cell."
)
@click.option(
    "--budget",
    type=Finite(min=1),
    default=120.0,
    show_default=True,
    help="Of the gate [s]; answers and counts are never cut short, times are.",
)
@click.option(
    "--plugin",
    "--method",
    "plugins",
    type=FILE,
    multiple=True,
    help="Your method's file as each side has it; exec:COMMAND runs in each side's folder.",
)
@click.option("--build", default="", metavar="COMMAND", help="Run in each side's folder first: make mine.so.")
@click.option(
    "--vehicle", "vehicles", multiple=True, metavar="V", help="In place of ukwial and bluerov2-heavy."
)
@click.option("--instructions/--no-instructions", default=True, help="Count them where valgrind is there.")
@click.option("--always", is_flag=True, help="Measure even where nothing that can matter differs.")
@click.option("--markdown", "markdown_file", type=PATH, help="Write the report into this file too.")
@click.option("--json", "json_file", type=PATH, help="Write verdict and record here.")
def command(
    base: str | None,
    head: str | None,
    base_path: Path | None,
    head_path: Path | None,
    repo: Path,
    cells: tuple[str, ...],
    threshold: float,
    pairs: int,
    budget: float,
    plugins: tuple[str, ...],
    build: str,
    vehicles: tuple[str, ...],
    instructions: bool,
    always: bool,
    markdown_file: Path | None,
    json_file: Path | None,
) -> int:
    """Did HEAD get slower than BASE, or wrong? Exit code 1 says yes.

    BASE and HEAD are git revisions; HEAD is the current commit unless given. In a repository of your own,
    --plugin names the file of your method in it. Exit codes: 0 pass, 1 regression, 2 bad usage, 3
    inconclusive.
    """
    from alloc import catalogue, list_vehicles
    from alloc.discovery import plugin_name
    from alloc.errors import UnknownName
    from alloc.files.textfile import write_text
    from alloc.vehicle.file import find_file, load_fixed_vehicle
    from bench.gate import trees
    from bench.gate.record import DEFAULT_CELLS, METHODS, VEHICLES, GateSettings, restrict_patterns
    from bench.gate.run import gate
    from bench.gate.verdict import as_json, markdown, verdict

    if bool(base) == bool(base_path):
        raise click.UsageError("give BASE or --base-path, one of them")
    if head and head_path:
        raise click.UsageError("give HEAD or --head-path, not both")
    if base_path and not head and not head_path:
        raise click.UsageError("--base-path needs HEAD or --head-path beside it")
    for vehicle in vehicles:
        load_fixed_vehicle(vehicle)
    sides = (
        trees.folder(base_path) if base_path else trees.revision(repo, str(base)),
        trees.folder(head_path) if head_path else trees.revision(repo, head or "HEAD"),
    )
    asked = vehicles or VEHICLES
    chosen = restrict_patterns(vehicles, cells) if vehicles else cells
    plugins = tuple(dict.fromkeys(plugins))
    methods = [plugin_name(plugin) for plugin in plugins]
    taken = [entry.name for entry in catalogue()]
    for plugin, method in zip(plugins, methods, strict=True):
        if [*taken, *methods].count(method) > 1:  # the other's answers would stand for the file's
            raise UnknownName(f"{plugin}: another method is called '{method}' too; rename the file")
    patterns = [f"{escape(vehicle)}:{escape(method)}" for vehicle in asked for method in methods]
    if not all(map(trees.is_own, sides)):
        patterns += [f"{escape(vehicle)}:{method}" for vehicle in asked for method in METHODS]
    record = gate(
        *sides,
        GateSettings(threshold=threshold / 100, pairs=pairs, budget_s=budget),
        patterns=chosen or patterns or DEFAULT_CELLS,
        plugins=plugins,
        vehicles={v: str(find_file(v).resolve()) for v in vehicles if v not in list_vehicles()},
        build=build,
        always=always,
        count=instructions,
        tell=lambda what: echo(what, err=True),
    )
    result = verdict(record)
    echo(markdown(record, result, folded=False), nl=False)
    if markdown_file:
        write_text(markdown_file, markdown(record, result))
    if json_file:
        write_text(json_file, as_json(record, result))
    return int(result.outcome)
