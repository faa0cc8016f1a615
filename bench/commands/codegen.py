"""``thrustbench codegen``."""

from pathlib import Path
from typing import Literal

import click

from bench.commands import (
    FAULTS,
    LIMITS,
    NOISE,
    PATH,
    SINGLE,
    echo,
    refuse_another_s,
    unread_output,
    wrench_noise,
)


@click.command()
@click.option("--vehicle", metavar="V", help="A shipped name or a YAML file.")
@click.option("--method", metavar="M", help="A method that has C.")
@click.option(
    "--library",
    is_flag=True,
    help="In place of a method: C that takes the matrix at run time, with room for 8 thrusters, or for V.",
)
@SINGLE
@LIMITS
@FAULTS
@click.option("--esc", is_flag=True, help="Also C from thrusts to the commands of the vehicle's ESCs.")
@click.option("--monitor", is_flag=True, help="Also C that accuses a thruster that pushes less than told.")
@NOISE
@click.option("--lasting", type=float, metavar="CALLS", help="Until that noise has forgotten itself. [25]")
@click.option("--cap", is_flag=True, help="Also C that keeps below a cap on current, of the call [A].")
@click.option(
    "--package",
    type=click.Choice(["cmake", "ros2", "platformio", "arduino", "zephyr"]),
    help="In a folder of its own, with what that build system asks for.",
)
@click.option("--maintainer", default="", metavar="'NAME <MAIL>'", help="Who looks after a ROS 2 package.")
@click.option("--out", required=True, type=PATH, metavar="DIR", help="Made if missing.")
@unread_output()
def command(
    vehicle: str | None,
    method: str | None,
    library: bool,
    single: bool,
    limits: Literal["fixed", "call"],
    faults: Literal["none", "one", "all"],
    esc: bool,
    monitor: bool,
    noise: str,
    lasting: float | None,
    cap: bool,
    package: Literal["cmake", "ros2", "platformio", "arduino", "zephyr"] | None,
    maintainer: str,
    out: Path,
) -> None:
    """Write C99 of one method for one vehicle, with its self-test.

    Header, source, self-test, and a page on how to call it. With --library it is libthrustbench, for vehicles
    whose matrix is known when they boot.
    """
    from alloc import generate, load_vehicle
    from alloc import library as made_at_boot
    from alloc.files.textfile import write_folder
    from alloc.lint.isolation import assumed_noise
    from alloc.vehicle.azimuth import refuse_azimuths

    scalar: Literal["double", "float"] = "float" if single else "double"
    known = load_vehicle(vehicle) if vehicle else None
    for option, value in (("--noise", noise or None), ("--lasting", lasting)):
        if value is not None and not monitor:
            raise click.UsageError(f"{option} is of --monitor; give that too")
    if library:
        if method or limits != "fixed" or faults != "one" or esc or monitor or cap:
            raise click.UsageError(
                "--library has every method, and limits of each call; leave out the others."
            )
        refuse_azimuths(known.azimuths if known else (), "libthrustbench", "its limits are a box")
        files = made_at_boot.generate(scalar, known, package, maintainer)
    elif known and method:
        observed = wrench_noise(known, noise)
        if monitor and observed is None:
            observed = assumed_noise(known)
        files = generate(
            known, method, scalar=scalar, limits=limits, faults=faults, esc=esc,
            monitor=observed, lasting=lasting, cap=cap, package=package, maintainer=maintainer,
        )  # fmt: skip
    else:
        raise click.UsageError(f"Missing option '{'--method' if vehicle else '--vehicle'}'.")
    refuse_another_s(out, files)
    write_folder(out, files)
    for name in files:
        echo(out / name)
    if known and limits == "fixed" and not library and known.by_volts:
        echo("limits are f_min and f_max; to have those of each voltage, --limits call", err=True)
    if package == "ros2" and not maintainer:
        echo("package.xml has a placeholder: say by --maintainer 'NAME <MAIL>' who looks after it", err=True)
