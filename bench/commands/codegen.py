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
@click.option("--esc", is_flag=True, help="And from thrusts to the commands of the vehicle's ESCs.")
@click.option(
    "--package",
    type=click.Choice(["cmake", "ros2", "platformio", "arduino", "zephyr"]),
    help="In a folder of its own, with what that build system asks for.",
)
@click.option("--out", required=True, type=PATH, metavar="DIR", help="Made if missing.")
def command(
    vehicle: str,
    method: str,
    single: bool,
    limits: Literal["fixed", "call"],
    esc: bool,
    package: Literal["cmake", "ros2", "platformio", "arduino", "zephyr"] | None,
    out: Path,
) -> None:
    """C99 of one method for one vehicle: header, source, self-test, and a page on how to call it."""
    from alloc import AllocError, generate, load_vehicle

    scalar: Literal["double", "float"] = "float" if single else "double"
    files = generate(load_vehicle(vehicle), method, scalar=scalar, limits=limits, esc=esc, package=package)
    refuse_another_s(out, files)
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (out / name).parent.mkdir(parents=True, exist_ok=True)
            (out / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise AllocError(f"{out}: can't be written ({error.strerror}); give another --out") from None
    for name in files:
        click.echo(out / name)
