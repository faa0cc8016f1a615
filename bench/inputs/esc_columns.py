"""Columns of what goes to the ESCs, and of the wrench that it makes."""

from collections.abc import Sequence

import numpy as np

from alloc import Allocation, Vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.esc import Made
from alloc.vehicle.frame import turned


def sent(
    vehicle: Vehicle,
    answers: Sequence[Allocation],
    t: FloatArray | None = None,
    volts: FloatArray | None = None,
    f_min: FloatArray | None = None,
    f_max: FloatArray | None = None,
    frame: str = "",
) -> tuple[dict[str, list[float]], str]:
    """Columns u0, u1, … of commands, made_surge, … of the wrench T P f that they make [N, N m], and a doubt.

    One entry an answer, whose voltage (N,) [V] and limits (N, n) [N] are given, or the vehicle's. Times (N,)
    [s], since the first one, and voltages stand behind, so that what was sent is a log of outputs. The wrench
    is in ``frame``, or the vehicle's. The doubt is about voltages at which nothing was measured, empty
    without any.
    """
    f = np.array([answer.f for answer in answers]).reshape(len(answers), vehicle.n)
    wired = vehicle.commands(f, volts, f_min=f_min, f_max=f_max)
    made = wired.f @ vehicle.TP.T
    if frame not in ("", vehicle.frame):
        made = turned(made.T, vehicle.dof).T
    columns = {f"u{i}": wired.u[:, i].tolist() for i in range(vehicle.n)}
    columns |= {f"made_{axis}": made[:, row].tolist() for row, axis in enumerate(vehicle.dof)}
    known = {"t": None if t is None else t - t[0], "volts": volts}
    columns |= {name: column.tolist() for name, column in known.items() if column is not None}
    outside = int((wired.status == Made.OUTSIDE_TABLE).any(axis=1).sum())
    if not outside:
        return columns, ""
    doubt = f"at the voltage of {outside} of {len(f)} rows no curve was measured: the nearest one is taken"
    return columns, f"{doubt}, also for made_{vehicle.dof[0]}, …"
