"""``thrustbench import``."""

from pathlib import Path

import click

from bench.commands import PATH, echo, not_over


@click.command()
@click.argument("file", type=PATH)
@click.option(
    "--format",
    "format_",
    default="",
    metavar="F",
    help="csv, mvp, px4, ros, sdf, tam, thrusters or urdf; else told by content.",
)
@click.option("--name", default="", help="Of the vehicle [the file's].")
@click.option("--dof", default="", metavar="A,B,…", help="Controlled DOF [as many as are independent].")
@click.option(
    "--frame", type=click.Choice(["frd", "flu"]), help="z down or z up, where the file does not say."
)
@click.option("--f-min", type=float, metavar="N", help="Lower limit of every thruster [N].")
@click.option("--f-max", type=float, metavar="N", help="Upper limit of every thruster [N].")
@click.option("--take", type=click.Choice(["T", "poses"]), help="Which to believe where they contradict.")
@click.option("--thruster", default="", metavar="PATTERN", help="Joints or links that are thrusters.")
@click.option("--limits", type=PATH, help="thruster_manager's parameters, with the limits of a URDF.")
@click.option("--suspect", default="", metavar="I,…", help="Thrusters whose column of T stands as published.")
@click.option("-o", "--output", type=PATH, help="Vehicle file [standard output].")
def command(
    file: Path,
    format_: str,
    name: str,
    dof: str,
    frame: str | None,
    f_min: float | None,
    f_max: float | None,
    take: str | None,
    thruster: str,
    limits: Path | None,
    suspect: str,
    output: Path | None,
) -> None:
    """Make a vehicle file of a URDF, SDF, ROS, PX4, YAML or CSV file.

    ROS: parameters of a thruster manager, or a TAM.yaml. YAML: thrusters with a position and a direction.
    CSV: rows of T.
    """
    from alloc.files.textfile import write_text
    from alloc.vehicle.keys import to_yaml
    from bench.inputs.imported import ImportOptions, import_vehicle

    not_over(output, file)
    options = ImportOptions(
        name=name,
        dof=split(dof),
        frame=frame or "",
        f_min=f_min,
        f_max=f_max,
        take=take or "",
        thruster=thruster,
        limits=limits,
        suspect=tuple(int(one) if one.isdecimal() else one for one in split(suspect)),
    )
    keys = import_vehicle(file, format_, options)
    if output is not None:
        write_text(output, to_yaml(keys))
    for note in keys.notes:
        echo(f"assumed: {note}", err=True)
    if output is None:
        echo(to_yaml(keys), nl=False)
    else:
        echo(f"{output} written; 'thrustbench check {output}' says what to look at", err=True)


def split(text: str) -> tuple[str, ...]:
    """The parts of a list with commas; none of an empty text."""
    return tuple(part.strip() for part in text.split(",")) if text else ()
