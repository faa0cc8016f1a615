"""``thrustbench canary``."""

from pathlib import Path

import click

from bench.commands import echo


@click.command()
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False), default=Path("canary.json"))
def command(file: Path) -> None:
    """Time fixed work on this machine, for `size --canary` elsewhere.

    FILE is canary.json unless given.
    """
    import msgspec

    from alloc.files.textfile import write_bytes
    from bench.harness.timing import measure_canaries

    canaries = measure_canaries()
    write_bytes(file, msgspec.json.format(msgspec.json.encode(canaries)) + b"\n", "give another file")
    for name, us in canaries.median_us.items():
        echo(f"{name}: {us:.3g} µs")
    echo(f"Written: {file}")
