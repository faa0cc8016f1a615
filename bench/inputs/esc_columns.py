"""Columns of what goes to the ESCs, and of the wrench that it makes."""

from collections.abc import Sequence

import numpy as np

from alloc import Allocation, Vehicle
from alloc.allocation import FloatArray


def sent(
    vehicle: Vehicle,
    answers: Sequence[Allocation],
    volts: FloatArray | None = None,
    f_min: FloatArray | None = None,
    f_max: FloatArray | None = None,
) -> dict[str, list[float]]:
    """Columns u0, u1, … of commands and made_surge, … of the wrench T P f that they make [N, N m].

    One entry an answer, whose voltage (N,) [V] and limits (N, n) [N] are given, or the vehicle's.
    """
    f = np.array([answer.f for answer in answers]).reshape(len(answers), vehicle.n)
    wired = vehicle.commands(f, volts, f_min=f_min, f_max=f_max)
    made = wired.f @ vehicle.TP.T
    columns = {f"u{i}": wired.u[:, i].tolist() for i in range(vehicle.n)}
    return columns | {f"made_{axis}": made[:, row].tolist() for row, axis in enumerate(vehicle.dof)}
