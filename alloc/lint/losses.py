"""The remarks on what failures cost, and on a vehicle that the exact method does not apply to."""

from collections.abc import Iterator, Sequence

from alloc.errors import NotApplicable
from alloc.lint.failures import Failure
from alloc.lint.report import Level, Remark, warning
from alloc.nullspace.allocator import exact
from alloc.vehicle import Vehicle

WORSE = 10.0
"""Factor on the condition number by which a failure nearly takes a direction away."""


def on_failures(found: Sequence[Failure], whole: float) -> Iterator[Remark]:
    """Remarks on the loss of one thruster; failures that cost the same share a remark.

    ``whole`` is the condition number before them.
    """
    alike: dict[tuple[Level, str], list[Failure]] = {}
    for failure in found:
        if failure.last or failure.lost:
            costs: tuple[Level, str] = ("warning", failure.words)
        elif failure.condition is not None and failure.condition > WORSE * whole:
            costs = "warning", f"a direction is all but lost (condition {failure.condition:.0f})"
        else:
            costs = "note", failure.words
        alike.setdefault(costs, []).append(failure)
    for (level, words), same in alike.items():
        numbers = "" if any(failure.name for failure in same) else "thruster "
        names = [failure.name or f"{'' if numbers else 'thruster '}{failure.thruster}" for failure in same]
        yield level, "", f"without {numbers}{_either(names)}: {words}"


def on_exact_method(vehicle: Vehicle) -> tuple[int | None, list[Remark]]:
    """Steps of the exact method at worst; None, and a remark, where it does not apply."""
    try:
        return exact(vehicle).worst_case_steps, []
    except NotApplicable as reason:
        return None, [warning("T", str(reason))]


def _either(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"
