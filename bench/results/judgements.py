"""Columns that are worked out from judgements: how right answers are, what they deliver and give away."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from alloc.vehicle.geometry import DOF, MOMENTS
from bench.record import Judged
from bench.results.repeats import most


class Worst(property):
    """A column with the worst number of the judgements of a row's repeats, None where none has it."""

    def __init__(
        self,
        meaning: str,
        of: Callable[[Judged], float | None],
        worst: Callable[[list[float]], float] = max,
    ) -> None:
        """Make the column of what it means, of the number of one judgement, and of what is worse."""

        def column(row: Any) -> float | None:
            values = [value for judged in row.measured.judged if (value := of(judged)) is not None]
            return worst(values) if values else None

        column.__doc__ = meaning  # as ``doc`` of a subclass's property, CPython 3.11 would lose it
        super().__init__(column)

    if TYPE_CHECKING:  # mypy takes the value of a property for Any unless a decorator made it
        # Of a class it would be itself, which nobody asks.
        def __get__(self, row: Any, owner: type | None = None, /) -> float | None: ...  # type: ignore[override]


def by_level(repeats: list[list[float]], of: Callable[[list[float]], float]) -> str:
    """One number of each level of a demand, over the repeats, in a cell; empty without levels."""
    levels = zip(*(shares for shares in repeats if shares), strict=True)
    return " ".join(f"{of(list(shares)):.6g}" for shares in levels)


def worst_axis(judged: Judged, moments: bool) -> float | None:
    """Largest |delivered - tau| on any force axis [N], or on any moment axis [N m]."""
    suffix = "max_Nm" if moments else "max_N"
    axes = [axis for axis in DOF if (axis in MOMENTS) == moments]
    return most(judged.loss.get(f"wrench_error_{axis}_{suffix}") for axis in axes)
