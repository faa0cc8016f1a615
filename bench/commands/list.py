"""``thrustbench list``."""

import click


@click.command()
def command() -> None:
    """Methods, demand sets, processors and vehicles; what is missing and how to get it."""
    from rich.console import Console
    from rich.table import Column, Table

    from alloc import catalogue, list_vehicles, load_vehicle
    from bench.chips.target import names
    from bench.demands import list_demands

    def table(title: str, *columns: str) -> Table:
        first, *others, last = columns
        name = Column(first, no_wrap=True)  # a name that is cut short can't be typed
        return Table(name, *others, Column(last, overflow="fold"), title=title, box=None)

    console = Console(highlight=False, markup=False)
    methods = table("Methods", "method", "formulation", "starts, levels", "what it does")
    for e in catalogue():
        choices = "\n".join(" ".join(names) for names in (e.starts, e.levels) if names != ("-",))
        methods.add_row(e.name, e.formulation, choices, e.missing or e.summary)
    console.print(methods)
    console.print("\nDemand sets:", ", ".join(list_demands()), "\nor a CSV, a ROS bag, a PX4 log")
    console.print("\nProcessors for `emulate` and `prove`:", ", ".join(names()), "\n")
    vehicles = table("Vehicles", "vehicle", "DOF", "thrusters", "d", "limits [N]", "source")
    for name in list_vehicles():
        v = load_vehicle(name)
        limits = f"{v.f_min.min():g} … {v.f_max.max():g}"
        vehicles.add_row(name, str(v.k), str(v.n), str(v.nullity), limits, v.source)
    console.print(vehicles)
