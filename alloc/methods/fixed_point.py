"""Fixed-point iteration: give what is still missing to the generalized inverse, clip, and again."""

import numpy as np

from alloc.allocation import WRENCH_TOLERANCE, FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.vehicle import Vehicle

FORMULATION = "fixed-point"

ITERATIONS = 100
"""Most iterations of one call: the default of QCAT's fxp_alloc."""

EPSILON = WRENCH_TOLERANCE / 10
"""Weight of the effort against the wrench error. It biases the wrench by as much, relative to the largest,
so the bias alone makes no demand PARTIAL."""

STILL = 1e-9
"""The iteration stops where no thrust moves by more than this share of the largest limit [-]."""


def build(vehicle: Vehicle) -> Saturating:
    """Prepare the iteration for the mixed objective of wrench error and effort.

    After Burken et al. 2001 (J. Guidance, Control, Dyn. 24(3)) and QCAT's fxp_alloc, started behind
    T* tau as in Omerdic & Roberts 2004 (Control Eng. Practice 12(12)).

    Minimises (1 - e)/2 |T f - tau|_W^2 + e/2 f'Hf inside the limits, W = (T H^-1 T')^-1, by
    projected gradient steps of length 1 in the metric H, the largest stable one:

        f <- clip((1 - e) (f + T* (tau - T f)))

    Clipping is the projection where H is diagonal. Convergence is linear and slow near the boundary,
    so a wrench that could be met may be missed when the iterations run out.
    """
    G = generalized_inverse(vehicle)
    step = (1 - EPSILON) * (np.eye(vehicle.n) - G @ vehicle.TP)
    drive = (1 - EPSILON) * G
    still = STILL * vehicle.f_scale

    def iterate(tau: FloatArray, start: list[float], limits: Bounds) -> tuple[list[float], int]:
        f_min, f_max = limits.low, limits.high
        towards = drive.dot(tau)
        f = np.minimum(np.maximum(start, f_min), f_max)
        taken, change = 0, np.inf
        while taken < ITERATIONS and change > still:
            moved = step.dot(f)
            moved += towards
            np.maximum(moved, f_min, out=moved)
            np.minimum(moved, f_max, out=moved)
            f -= moved
            change = max(map(abs, f.tolist()))
            f = moved
            taken += 1
        return f.tolist(), taken

    def iterate_many(taus: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        towards = taus @ drive.T
        F = F.clip(low, high)
        moving = np.arange(len(F))
        for _ in range(ITERATIONS):
            moved = (F[moving] @ step.T + towards[moving]).clip(low[moving], high[moving])
            change = np.abs(moved - F[moving]).max(axis=1, initial=0.0)
            F[moving] = moved
            moving = moving[change > still]
        return F

    return Saturating(vehicle, FORMULATION, iterate, iterate_many, tolerance=WRENCH_TOLERANCE)
