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

    from bench.harness.canary import measure
    from bench.record.canary import CanaryError

    canaries = measure()
    try:
        file.write_bytes(msgspec.json.format(msgspec.json.encode(canaries)) + b"\n")
    except OSError as error:
        raise CanaryError(f"{file}: can't be written ({error.strerror}); give another file") from None
    for name, us in canaries.median_us.items():
        click.echo(f"{name}: {us:.3g} µs")
    click.echo(f"Written: {file}")
