"""Names of thrusters: what may be one, and which thruster has it."""

from collections.abc import Sequence

from alloc.errors import VehicleError, unknown

LONGEST = 40
"""Most characters of a thruster's name, since it stands in tables, pictures and headers."""
TAKEN = set('@,"/')
"""Characters that ``--fault`` and CSV use, and file names can't have."""


def index_of(name: str, names: Sequence[str], vehicle: str) -> int:
    """Index of the thruster with that name; raises VehicleError with the ``vehicle`` and its names."""
    if name and name in names:
        return names.index(name)
    if not any(names):
        raise VehicleError(f"{vehicle}: no thruster has the name {name[:40]!r}, nor any other; give a number")
    raise VehicleError(f"{vehicle}: {unknown('thruster', name, filter(None, names))}", "names")


def listed(asked: Sequence[int | str], names: Sequence[str], n: int, what: str, key: str) -> set[int]:
    """Indices of those of n thrusters that a file's ``what`` lists by index or name; raises VehicleError."""
    found = set()
    for one in asked:
        try:
            i = index_of(one, names, what) if isinstance(one, str) else one
        except VehicleError as error:
            raise VehicleError(str(error), key) from None
        if not 0 <= i < n:
            raise VehicleError(f"{what}: there is no thruster {i}; count from 0 to {n - 1}", key)
        found.add(i)
    return found


def check_names(names: Sequence[str], n: int) -> None:
    """Raise VehicleError unless there is a name for each of n thrusters ("" for none), or no name at all."""
    if names and len(names) != n:
        raise VehicleError(f"names: {len(names)} for {n} thrusters; give one each", "names")
    for name in filter(None, names):
        told_apart = not TAKEN & set(name) and not name.isdecimal() and name != "each"
        if len(name) > LONGEST or not name.isprintable() or name != name.strip() or not told_apart:
            raise VehicleError(
                f"names: {name[:40]!r} can't be typed; give up to {LONGEST} printable characters without"
                " @ , / or quotes, and no number",
                "names",
            )
        if names.count(name) > 1:
            raise VehicleError(f"names: {name!r} stands twice; give each thruster its own", "names")
