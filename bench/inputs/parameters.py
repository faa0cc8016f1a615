"""Looks keys up in parameter files, at any depth, and checks their values."""

from typing import Any

from alloc.errors import VehicleError
from alloc.files.yaml_tree import YamlTree
from alloc.vehicle.keys import Numbers


def find(tree: YamlTree, *names: str) -> Any:
    """The value of the first key with one of these names, outermost and topmost first; None without one."""
    level = [tree.data]
    while level:
        maps = [data for data in level if isinstance(data, dict)]
        for data in maps:
            for name in names:
                if name in data:
                    return data[name]
        level = [value for data in maps for value in data.values()]
    return None


def places(data: Any, name: str, within: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Below which keys one of that name stands, from outermost to innermost: an entry for each time."""
    if not isinstance(data, dict):
        return []
    inner = (places(value, name, (*within, str(key))) for key, value in data.items())
    return [*([within] if name in data else []), *(place for found in inner for place in found)]


def numbers(tree: YamlTree, key: str, value: Any) -> Numbers:
    """A flat list of numbers; raises VehicleError."""
    if not isinstance(value, list):
        raise VehicleError(f"{tree.path}: {key} is {_brief(value)}; give a list of numbers")
    for x in value:
        if not isinstance(x, (int, float)) or isinstance(x, bool):
            raise VehicleError(
                f"{tree.path}: {key} holds {_brief(x)}, which is no number; write it as 0.5 or -40"
            )
    return [float(x) for x in value]


def _brief(value: Any) -> str:
    """The value in a few words."""
    kinds = {dict: "a table of keys", list: "a list", type(None): "empty"}
    return kinds.get(type(value), repr(str(value))[:42])


def rows(tree: YamlTree, key: str, value: Any, n: int | None = None) -> list[Numbers]:
    """A matrix given as rows, or flat with n columns; raises VehicleError."""
    if isinstance(value, list) and value and all(isinstance(row, list) for row in value):
        matrix = [numbers(tree, key, row) for row in value]
    else:
        flat = numbers(tree, key, value)
        if not n or not flat or len(flat) % n:
            remedy = f"give {n} for each row" if n else "give 'thrusters: num:' to split it"
            raise VehicleError(f"{tree.path}: {key} has {len(flat)} numbers; {remedy}")
        matrix = [flat[i : i + n] for i in range(0, len(flat), n)]
    if len({len(row) for row in matrix}) != 1 or not matrix[0]:
        raise VehicleError(
            f"{tree.path}: rows of {key} differ in length or are empty; give one entry a thruster"
        )
    return matrix
