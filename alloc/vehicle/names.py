"""Names of thrusters, and axes in levels: the checks of both."""

import re
from collections.abc import Sequence
from operator import index

from alloc.errors import VehicleError, unknown

LONGEST = 40
"""Most characters of a thruster's name, since it stands in tables, pictures and headers."""
TAKEN = set('@,"/')
"""Characters that ``--fault`` and CSV use, and file names can't have."""
_COLUMN = re.compile(rf"[fu](\d{{1,{LONGEST}}})", re.IGNORECASE)
"""Columns that go by number: ``f1``, ``f1_min``, ``u1``."""


def thruster_index(thruster: int | str, names: Sequence[str], n: int, vehicle: str) -> int:
    """Index of one of n thrusters, given by index or by name; raises VehicleError, with the ``vehicle``."""
    if not isinstance(thruster, str):
        try:
            i = -1 if isinstance(thruster, bool) else index(thruster)  # True would be thruster 1
        except TypeError:
            i = -1
        if not 0 <= i < n:
            raise VehicleError(f"{vehicle}: there is no thruster {thruster!s:.40}; count from 0 to {n - 1}")
        return i
    if thruster and thruster in names:
        return names.index(thruster)
    if not any(names):
        raise VehicleError(
            f"{vehicle}: no thruster has the name {thruster[:40]!r}, nor any other; give a number"
        )
    raise VehicleError(f"{vehicle}: {unknown('thruster', thruster, filter(None, names))}", "names")


def listed(asked: Sequence[int | str], names: Sequence[str], n: int, what: str, key: str) -> set[int]:
    """Indices of those of n thrusters that a file's ``what`` lists by index or name; raises VehicleError."""
    try:
        return {thruster_index(one, names, n, what) for one in asked}
    except VehicleError as error:
        raise VehicleError(str(error), key) from None


def is_index(text: str) -> bool:
    """True if a text is a number where a thruster may be given by number or by name."""
    return text.strip().lstrip("+-").isdecimal()


def unmistakable(names: Sequence[str]) -> tuple[list[str], str]:
    """The names, "" in place of each that columns take for another thruster's number, and a remark on these.

    The second thruster's limit stands in a column ``f1_min``, which would be the first's if that were ``f1``.
    The remark is empty where all names stay.
    """
    found = [_COLUMN.fullmatch(name.strip()) for name in names]
    mistaken = [i for i, number in enumerate(found) if number and int(number[1]) != i]
    remark = ", ".join(f"{names[i].strip()} is thruster {i}" for i in mistaken)
    kept = ["" if i in mistaken else name for i, name in enumerate(names)]
    return kept, f"Names that are other thrusters' numbers are left out: {remark}." if remark else ""


def check_names(names: Sequence[str], n: int) -> None:
    """Raise VehicleError unless there is a name for each of n thrusters ("" for none), or no name at all."""
    if names and len(names) != n:
        raise VehicleError(f"names: {len(names)} for {n} thrusters; give one each", "names")
    for name in filter(None, names):
        told_apart = not TAKEN & set(name) and not is_index(name) and name != "each"
        if len(name) > LONGEST or not name.isprintable() or name != name.strip() or not told_apart:
            raise VehicleError(
                f"names: {name[:40]!r} can't be typed; give up to {LONGEST} printable characters without"
                " @ , / or quotes, and no number",
                "names",
            )
        if names.count(name) > 1:
            raise VehicleError(f"names: {name!r} stands twice; give each thruster its own", "names")
    for i, (name, kept) in enumerate(zip(names, unmistakable(names)[0], strict=True)):
        if name != kept:
            raise VehicleError(
                f"names: {name!r} is thruster {i}, but columns f{name[1:]}_min and u{name[1:]} are another's;"
                f" count from 0, as in {name[0]}{i}, or take another letter: t{name[1:]}",
                "names",
            )


Priority = tuple[tuple[str, ...], ...]
"""Axes in levels, the first level served first."""


def checked_priority(levels: Sequence[Sequence[str]], dof: Sequence[str]) -> Priority:
    """The levels as tuples; one level with all axes where there are none. Raises as ``checked_levels``."""
    return checked_levels(levels, dof, "priority") or (tuple(dof),)


def checked_levels(
    levels: Sequence[Sequence[str]], dof: Sequence[str], key: str, word: str = "level"
) -> Priority:
    """The levels, or groups, of a key of the file as tuples.

    Raises VehicleError unless each axis of ``dof`` stands in exactly one, and every one has an axis; none at
    all may be given.
    """
    if not levels:
        return ()
    named: list[str] = []
    for i, level in enumerate(levels):
        if not level:
            raise _refused(key, f"{word} {i + 1} is empty; name its axes, or leave it out")
        for axis in level:
            if axis not in dof:
                raise _refused(
                    key, f"{str(axis)[:40]!r} does not stand in 'dof'; give one of {', '.join(dof)}"
                )
            if axis in named:
                raise _refused(key, f"{axis} stands twice; name each axis once")
            named.append(axis)
    for axis in dof:
        if axis not in named:
            raise _refused(key, f"{axis} is missing; put each axis in 'dof' into one of the {word}s")
    return tuple(map(tuple, levels))


def axis_levels(priority: Priority, dof: Sequence[str]) -> list[int]:
    """The level of each axis of ``dof``, counted from 0."""
    return [next(i for i, axes in enumerate(priority) if axis in axes) for axis in dof]


def _refused(key: str, why: str) -> VehicleError:
    return VehicleError(f"{key}: {why}", key)
