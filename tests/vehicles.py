"""Vehicles that tests make up from a few numbers."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.autopilot import make_autopilot

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def made_up(T: ArrayLike, f_min: ArrayLike = -100.0, f_max: ArrayLike = 100.0, **others: Any) -> Vehicle:
    """Vehicle with that T (k, n) and limits (n,) or for all [N]; what is not given is one or the identity."""
    matrix = np.array(T, dtype=float)
    k, n = matrix.shape
    low, high = (np.broadcast_to(np.asarray(side, dtype=float), n).copy() for side in (f_min, f_max))
    usual = {"name": "made-up", "dof": AXES[:k], "H": np.eye(n), "readiness": np.ones(n)}
    fields: dict[str, Any] = usual | {"slack_weights": np.ones(k)} | others
    return Vehicle(T=matrix, f_min=low, f_max=high, **fields)


def with_autopilot(vehicle: Vehicle) -> Vehicle:
    """The vehicle of four thrusters with an autopilot, so that no method refuses it."""
    mixer = make_autopilot("SIMPLEROV_4", (vehicle.f_min, vehicle.f_max))
    return replace(vehicle, autopilot=mixer)


def made_by_few(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """Demands (n, k) [N, N m] that few thrusters make ahead, at their limits and inside; the others rest."""
    part = rng.choice([0.0, 1.0, 2.0], (n, vehicle.n), p=[0.6, 0.2, 0.2])
    F = np.where(part == 2.0, rng.random((n, vehicle.n)), part) * vehicle.f_max
    taus: FloatArray = F @ vehicle.TP.T
    return taus
