"""Which axes are served first when a demand can't be met."""

from collections.abc import Sequence

from alloc.errors import VehicleError

Priority = tuple[tuple[str, ...], ...]
"""Axes in levels, the first level served first."""


def checked_priority(levels: Sequence[Sequence[str]], dof: Sequence[str]) -> Priority:
    """The levels as tuples; one level with all axes where there are none.

    Raises VehicleError unless each axis of ``dof`` stands in exactly one level, and every level has one.
    """
    if not levels:
        return (tuple(dof),)
    named: list[str] = []
    for i, level in enumerate(levels):
        if not level:
            raise _refused(f"level {i + 1} is empty; name its axes, or leave it out")
        for axis in level:
            if axis not in dof:
                raise _refused(f"{str(axis)[:40]!r} does not stand in 'dof'; give one of {', '.join(dof)}")
            if axis in named:
                raise _refused(f"{axis} stands twice; name each axis once")
            named.append(axis)
    for axis in dof:
        if axis not in named:
            raise _refused(f"{axis} is missing; put each axis in 'dof' into one of the levels")
    return tuple(map(tuple, levels))


def _refused(why: str) -> VehicleError:
    return VehicleError(f"priority: {why}", "priority")
