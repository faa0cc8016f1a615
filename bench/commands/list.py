"""``thrustbench list``."""

import click


@click.command()
def command() -> None:
    """Methods, solvers and vehicles; what is missing and how to get it."""
    from rich.console import Console
    from rich.table import Table

    from alloc import catalogue, list_vehicles, load_vehicle

    console = Console()
    methods = Table("method", "formulation", "starts", "levels", "what it does", title="Methods", box=None)
    for e in catalogue():
        methods.add_row(e.name, e.formulation, " ".join(e.starts), " ".join(e.levels), e.missing or e.summary)
    console.print(methods)
    vehicles = Table("vehicle", "DOF", "thrusters", "d", "limits [N]", "source", title="Vehicles", box=None)
    for name in list_vehicles():
        v = load_vehicle(name)
        limits = f"{v.f_min.min():g} … {v.f_max.max():g}"
        vehicles.add_row(name, str(v.k), str(v.n), str(v.nullity), limits, v.source)
    console.print(vehicles)
