"""``thrustbench list``."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.console import Console

WIDE = 140
"""Columns of a terminal from which on there is room for words beside names."""


@click.command()
def command() -> None:
    """List methods, demand sets, processors, boards and vehicles.

    What is missing is named with how to get it.
    """
    from rich.console import Console

    from alloc import catalogue, list_vehicles, load_vehicle
    from bench.chips.boards import boards
    from bench.chips.processors import names
    from bench.demands import list_demands

    console = Console(highlight=False, markup=False)
    methods = []
    for e in catalogue():
        choices = "; ".join(" ".join(names) for names in (e.starts, e.levels) if names != ("-",))
        methods.append((e.name, e.formulation, choices, e.missing or e.summary))
    _table(console, ("method", "formulation", "starts, levels", "what it does"), methods)
    console.print("\nDemand sets:", ", ".join(list_demands()), "\nor a CSV, a ROS bag, a PX4 log")
    console.print("\nProcessors for `emulate` and `prove`:", ", ".join(names()))
    there = (board.name for processor in names() for board in boards(processor))
    console.print("\nBoards for `size --board`:", ", ".join(there), "\n")
    vehicles = []
    for name in sorted([*list_vehicles(), *list_vehicles(azimuths=True)]):
        v = load_vehicle(name)
        limits = f"{v.f_min.min():g} … {v.f_max.max():g}"
        source = f"{len(v.azimuths)} of them turn; {v.source}" if v.azimuths else v.source
        vehicles.append((name, str(v.k), str(len(v.actuators)), str(v.nullity), limits, source))
    _table(console, ("vehicle", "DOF", "thrusters", "d", "limits [N]", "source"), vehicles)


def _table(console: "Console", headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """A line each, the words of the last column beside it where there is room, else under it."""
    from rich.padding import Padding
    from rich.table import Table

    if console.width >= WIDE:
        table = Table(box=None, pad_edge=False)
        for heading in headings:
            # A name that is cut short can't be typed.
            table.add_column(heading, no_wrap=heading != headings[-1])
        for row in rows:
            table.add_row(*row)
        console.print(table)
        return
    widths = [max(len(row[i]) for row in (headings, *rows)) for i in range(len(headings) - 1)]
    for *cells, words in (headings, *rows):
        line = "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True))
        console.print(line.rstrip(), soft_wrap=True)
        console.print(Padding(words, (0, 0, 0, 4)))
