"""Weighted least squares with some thrusts held: the thrust that each thruster aims at."""

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.errors import NotApplicable
from alloc.vehicle import Vehicle

STEPS_PER_THRUSTER = 4
"""Most steps of a call to the soft method, for each thruster. The cost falls with each step, so that they end
at the optimum. After how many is not proven; ``docs/studies/soft.py steps`` counts them."""

LEAST = 1e-12
"""Distance from an aim that counts as none, at least, relative to the largest thrust of a call [-]."""


def aims(vehicle: Vehicle, free: IndexArray) -> FloatArray:
    """Rows (S, n, k) by which thrusters aim at a wrench, for S sets of free ones as bit masks.

    Row i of a set is the thrust of thruster i that minimises 1/2 f'Hf + 1/2 s'Qs with s = T P f - r, where i
    and the free ones may move, the others are zero, and r is the wrench that is left to them. With
    B = Q^1/2 T P H^-1/2 over those that may move, B = U S V', the minimiser is

        f = H^-1/2 V S (S^2 + I)^-1 U' Q^1/2 r

    which squares no condition, as normal equations do. Raises NotApplicable where H is not diagonal, as held
    thrusts would pull others with them then.
    """
    weights = np.diag(vehicle.H)
    if np.count_nonzero(vehicle.H - np.diag(weights)):
        raise NotApplicable(
            f"{vehicle.name}: H couples thrusters, and soft takes a diagonal one; give `weights`, or take"
            " qp-soft/daqp"
        )
    bits = 1 << np.arange(vehicle.n)
    with_own = free[:, None] | bits
    sets, which = np.unique(with_own, return_inverse=True)
    cheap, dear = 1.0 / np.sqrt(weights), np.sqrt(vehicle.slack_weights)
    whole = dear[:, None] * vehicle.TP * cheap
    U, S, Vt = np.linalg.svd(np.where((sets[:, None] & bits > 0)[:, None], whole, 0.0), full_matrices=False)
    shrunk = (S / (S * S + 1.0))[:, None]
    gains = cheap[:, None] * (Vt.transpose(0, 2, 1) * shrunk) @ U.transpose(0, 2, 1) * dear
    rows: FloatArray = gains[which.reshape(with_own.shape), np.arange(vehicle.n)]
    return rows


def rounded(vehicle: Vehicle, rows: FloatArray, unit: float) -> float:
    """Share of a thrust that rounding may take of an aim, where numbers round to ``unit`` [-].

    An aim adds up k products with the rest of a wrench, to which n products add up.
    """
    made = np.maximum(np.abs(vehicle.TP).sum(axis=1), vehicle.wrench_scale / vehicle.f_scale)
    return max(LEAST, float((vehicle.k + vehicle.n) * unit * (np.abs(rows) @ made).max()))
