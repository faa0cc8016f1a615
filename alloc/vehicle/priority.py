"""Priority of axes when a demand can't be met: levels, each served before the next."""

from collections.abc import Sequence

from alloc.errors import VehicleError

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


def _refused(key: str, why: str) -> VehicleError:
    return VehicleError(f"{key}: {why}", key)
