"""What the answers of some repeats deliver of their demands, and what they give away."""

from collections.abc import Callable

from alloc.vehicle.geometry import DOF, MOMENTS
from bench.results.repeats import Repeats, most


def by_level(repeats: list[list[float]], of: Callable[[list[float]], float]) -> str:
    """One number of each level of a demand, over the repeats, in a cell; empty without levels."""
    levels = zip(*(shares for shares in repeats if shares), strict=True)
    return " ".join(f"{of(list(shares)):.6g}" for shares in levels)


def lost(measured: Repeats, key: str, worst: Callable[[list[float]], float] = max) -> float | None:
    """The worst of a number of ``loss`` over the repeats, the largest unless told; None where none has it."""
    values = [value for j in measured.judged if (value := j.loss.get(key)) is not None]
    return worst(values) if values else None


def worst_axis(measured: Repeats, moments: bool) -> float | None:
    """Largest |delivered - tau| on any force axis [N], or on any moment axis [N m]."""
    suffix = "max_Nm" if moments else "max_N"
    axes = [axis for axis in DOF if (axis in MOMENTS) == moments]
    return most(lost(measured, f"wrench_error_{axis}_{suffix}") for axis in axes)
