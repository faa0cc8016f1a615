"""``thrustbench canary``."""

from pathlib import Path

import click


@click.command()
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False), default=Path("canary.json"))
def command(file: Path) -> None:
    """Time fixed work on this machine, for `size --canary` elsewhere.

    FILE is canary.json unless given.
    """
    import msgspec

    from alloc.files.textfile import write_bytes
    from bench.harness.canary import measure

    canaries = measure()
    write_bytes(file, msgspec.json.format(msgspec.json.encode(canaries)) + b"\n", "give another file")
    for name, us in canaries.median_us.items():
        click.echo(f"{name}: {us:.3g} µs")
    click.echo(f"Written: {file}")
