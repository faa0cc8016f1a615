"""``thrustbench init``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from bench.commands import echo

if TYPE_CHECKING:
    from alloc.vehicle.keys import VehicleFile


@click.command()
@click.argument("name")
@click.option("--like", default="", metavar="VEHICLE", help="Start from this one; else a few questions.")
@click.option(
    "--language",
    type=click.Choice(["python", "c", "cpp", "rust", "exec"]),
    default="python",
    show_default=True,
    help="Of the plug-in.",
)
def command(name: str, like: str, language: str) -> None:
    """Write files to start from: a vehicle, demands and a plug-in.

    They are NAME.yaml, demands.csv, and my_allocator.py, or what a plug-in in C, C++ or Rust is built of;
    exec is a program that answers line by line.
    """
    from alloc import load_vehicle
    from alloc.errors import FileError
    from alloc.files.textfile import write_text
    from alloc.vehicle.azimuth import refuse_azimuths
    from alloc.vehicle.file import build_vehicle, find_file, read_document
    from bench.inputs import starter

    name = starter.check_name(name.removesuffix(".yaml"))
    vehicle_file, demands = Path(f"{name}.yaml"), Path("demands.csv")
    turning = load_vehicle(like).azimuths if like else ()
    if language != "python":
        refuse_azimuths(turning, f"--language {language}", "limits of its calls are boxes")
    files = starter.plugin("My allocator", language, azimuths=bool(turning))
    methods = {Path(file): text for file, text in files.items()}
    for file in (vehicle_file, demands, *methods):
        if file.exists():
            raise FileError("is there already, and nothing is replaced; go to another folder", path=file)
    keys = starter.copy_keys(name, read_document(find_file(like)).keys, like) if like else _asked(name)
    text = starter.keys_text(keys)
    vehicle = build_vehicle(keys)
    write_text(vehicle_file, text)
    write_text(demands, starter.first_demands(vehicle))
    for file, text in methods.items():
        file.parent.mkdir(exist_ok=True)
        write_text(file, text)
        if text.startswith("#!"):
            file.chmod(0o755)
    source, (_, build, method) = next(iter(methods)), starter.LANGUAGES[language]
    builds = f"{build} && \\\n  " if build else ""
    echo(
        f"{vehicle_file}  the vehicle: put your own numbers in, then  thrustbench check {vehicle_file}\n"
        f"{demands}  each axis alone, then together:  thrustbench allocate --vehicle {vehicle_file}"
        f" --method nullspace {demands}\n"
        f"{source}  a method of yours:  {builds}thrustbench run --vehicle {vehicle_file} --method {method}"
        " --method nullspace --method pinv --quick"
    )


def _asked(name: str) -> "VehicleFile":
    """The vehicle that a few questions on the terminal describe."""
    import sys

    from bench.inputs.starter import sketch_keys

    def ask(question: str, default: float) -> float:
        return float(click.prompt(question, default=default, type=float, err=True))

    try:
        echo("Four horizontal thrusters at the corners; Enter takes what is in brackets.", err=True)
        length = ask("Between front and rear thrusters [m]", 0.4)
        width = ask("Between port and starboard thrusters [m]", 0.3)
        angle = ask("Angle of the horizontal ones from straight ahead; 0 for two that push ahead [deg]", 45)
        vertical = ask("Vertical thrusters: 0, 1, 2 (port, starboard) or 4 (corners)", 4)
        ahead = ask("Full thrust of one ahead [N]", 51.5)
        astern = ask("Full thrust of one astern [N]", 40.2)
    except click.exceptions.Abort:
        if sys.stdin.isatty():
            raise
        raise click.UsageError("no answers on standard input; give --like VEHICLE") from None
    return sketch_keys(name, length, width, angle, round(vertical), ahead, astern)
