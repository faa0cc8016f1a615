"""Seeded vehicles of any nullity, and demands whose verdict is known by how they were made."""

from dataclasses import dataclass

import numpy as np

from alloc import Vehicle

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
SHAPES = [(1, 1), (1, 3), (3, 3), (3, 4), (2, 4), (6, 8), (3, 6), (4, 8), (2, 6)]
"""(k, n): nullity 0, 2, 0, 1, 2, 2, 3, 4, 4."""
EDGE = 1e-6
"""Step across the boundary, relative to the attainable set: a thousand times the method's tolerance."""


@dataclass(frozen=True)
class Demands:
    """Demands of known verdict.

    Attributes
    ----------
    taus : (N, k) wrenches [N, N m]
    attainable : (N,) whether each can be met
    """

    taus: np.ndarray
    attainable: np.ndarray


def random_vehicle(k: int, n: int, rng: np.random.Generator, diagonal: bool = True) -> Vehicle:
    """Generic T, asymmetric limits (some that exclude zero), H diagonal or full."""
    f_min, f_max = -rng.uniform(10, 100, n), rng.uniform(10, 100, n)
    f_min[0] *= rng.choice([1.0, -0.05])  # thruster 0 of some vehicles must always push
    root = rng.normal(size=(n, n))
    H = np.diag(rng.uniform(0.5, 2.0, n)) if diagonal else root @ root.T + np.eye(n)
    return Vehicle(
        name=f"random-{k}x{n}",
        dof=AXES[:k],
        T=rng.normal(size=(k, n)),
        H=H,
        f_min=f_min,
        f_max=f_max,
        readiness=np.ones(n),
        slack_weights=np.ones(k),
    )


def face_thrusts(vehicle: Vehicle, rng: np.random.Generator) -> np.ndarray:
    """Thrusts whose wrench lies on a facet of the attainable set: no other thrusts make that wrench.

    The normal c of the facet is orthogonal to k - 1 columns of T. Those k - 1 thrusters are free between
    their limits; the others stand at the limit that c favours, so that c'T f is the largest possible.
    """
    k, n = vehicle.k, vehicle.n
    free = rng.choice(n, k - 1, replace=False)
    c = np.linalg.svd(vehicle.T[:, free].T)[2][-1]
    f = np.where(c @ vehicle.T > 0, vehicle.f_max, vehicle.f_min)
    f[free] = rng.uniform(vehicle.f_min[free], vehicle.f_max[free])
    return f


def vertex_thrusts(vehicle: Vehicle, rng: np.random.Generator) -> np.ndarray:
    """Thrusts whose wrench is a vertex of the attainable set: each at the limit that a direction favours."""
    return np.where(rng.normal(size=vehicle.k) @ vehicle.T > 0, vehicle.f_max, vehicle.f_min)


def demands_of_known_verdict(vehicle: Vehicle, n: int, rng: np.random.Generator) -> Demands:
    """Demands that lie, in turn, inside, at a vertex, on a facet, EDGE inside and outside it, far outside."""
    center = vehicle.T @ (vehicle.f_min + vehicle.f_max) / 2
    taus, attainable = [], []
    for i in range(n):
        kind = i % 6
        if kind == 0:
            tau = vehicle.T @ rng.uniform(vehicle.f_min, vehicle.f_max)
        elif kind == 1:
            tau = vehicle.T @ vertex_thrusts(vehicle, rng)
        else:
            growth = (1.0, 1.0 - EDGE, 1.0 + EDGE, rng.uniform(1.01, 3.0))[kind - 2]
            tau = center + growth * (vehicle.T @ face_thrusts(vehicle, rng) - center)
        taus.append(tau)
        attainable.append(kind < 4)
    return Demands(np.array(taus), np.array(attainable))
