"""``thrustbench codegen``."""

from pathlib import Path
from typing import Literal

import click

from bench.commands import LIMITS, PATH, SINGLE, refuse_another_s


@click.command()
@click.option("--vehicle", required=True, metavar="V", help="A shipped name or a YAML file.")
@click.option("--method", required=True, metavar="M", help="A method that can be C.")
@SINGLE
@LIMITS
@click.option("--out", required=True, type=PATH, metavar="DIR", help="Made if missing.")
def command(vehicle: str, method: str, single: bool, limits: Literal["fixed", "call"], out: Path) -> None:
    """C99 of one method for one vehicle: header, source, self-test, and a page on how to call it."""
    from alloc import AllocError, catalogue, load_vehicle
    from alloc.native import generate, page
    from alloc.native.generate import function_name

    loaded = load_vehicle(vehicle)
    kernel = {entry.name: entry.twin for entry in catalogue() if entry.twin}.get(method, method)
    scalar: Literal["double", "float"] = "float" if single else "double"
    called = f"{function_name(loaded, kernel, scalar, limits)}.md"  # several functions may share a folder
    files = generate(loaded, kernel, scalar, limits=limits)
    files[called] = page(loaded, kernel, scalar, limits)
    refuse_another_s(out, files)
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (out / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise AllocError(f"{out}: can't be written ({error.strerror}); give another --out") from None
    for name in files:
        click.echo(out / name)
