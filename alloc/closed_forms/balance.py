"""The step along one axis that brings thrusts, or outputs, back between their limits."""

from collections.abc import Sequence


def balancing_step(
    f: Sequence[float], column: Sequence[float], limits: Sequence[tuple[float, float]], weak: float
) -> float:
    """Amount of an axis to add so that the worst excess on either side is balanced; 0 if there is none.

    The sum of the two extreme steps, as in PX4's ControlAllocationSequentialDesaturation. Entries of
    ``column`` below ``weak`` are left out: moving these a little would cost all of the axis.
    """
    least = most = 0.0
    for x, c, (low, high) in zip(f, column, limits, strict=True):
        if low <= x <= high or abs(c) < weak or not c:
            continue
        step = ((low if x < low else high) - x) / c
        least, most = min(least, step), max(most, step)
    return least + most
