"""Demands for the suite and the equations that its answers must satisfy."""

from collections.abc import Sequence

import numpy as np

from alloc import Allocation, Allocator, Status, Vehicle
from alloc.allocation import FloatArray
from alloc.inverse import generalized_inverse

N_DEMANDS = 100

WRENCH_TOLERANCE = 1e-6
"""What SOLVED promises, relative to the wrench scale of each axis."""


def inactive_sequence(vehicle: Vehicle) -> FloatArray:
    """(N_DEMANDS, k) wrenches along a closed path [N, N m], T* tau at most 60 % of the limits.

    A path and not a random set, because that is what a controller asks for and what a warm start is
    made for. Thrusts swing sinusoidally, each at its own whole frequency and phase.
    """
    phase = np.linspace(0.0, 2.0 * np.pi, N_DEMANDS, endpoint=False)[:, None]
    i = np.arange(vehicle.n)
    taus = (vehicle.f_max * np.sin((1 + i % 3) * phase + i)) @ vehicle.TP.T
    used: float = _share_of_limits(taus @ generalized_inverse(vehicle).T, vehicle)
    return 0.6 / used * taus


def judge(
    vehicle: Vehicle, allocator: Allocator, taus: FloatArray, answers: Sequence[Allocation]
) -> dict[str, float]:
    """Assert that every answer to an inactive demand is right; what was found, in figures."""
    F = np.array([answer.f for answer in answers])
    statuses = {Status(answer.status).name for answer in answers}
    assert len(answers) == len(taus)
    assert statuses == {"SOLVED"}, f"inactive demands can all be met; statuses are {statuses}"
    wrench_error = float((np.abs(F @ vehicle.TP.T - taus) / vehicle.wrench_scale).max())
    assert wrench_error <= WRENCH_TOLERANCE or allocator.formulation == "soft"
    return {"wrench_error_rel_max": wrench_error, "share_of_limits_max": _share_of_limits(F, vehicle)}


def _share_of_limits(F: FloatArray, vehicle: Vehicle) -> float:
    on = vehicle.working
    return float(np.maximum(F[:, on] / vehicle.f_max[on], F[:, on] / vehicle.f_min[on]).max())
