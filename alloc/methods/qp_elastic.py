"""Elastic allocation: the wrench may be missed at a price for each N or N m, limits are kept."""

from threading import Lock

import numpy as np

from alloc import solvers
from alloc.allocation import FloatArray, Status
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.formulations.elastic import FORMULATION as ANSWERED
from alloc.methods import Variant
from alloc.solvers.elastiqp import prepare_rows
from alloc.vehicle import Vehicle

FORMULATION = ANSWERED.name
FOREIGN = True

PRICE = 1e6
"""Price of a miss [-], in rows of T of unit length, thrusts over the largest limit and H over its largest
entry. Where a multiplier is larger, a wrench that can be met is missed."""
PRICE_OF_LIMITS = 1e12
"""The same for limits, which the solver lets give way too [-]: so high that none pays."""


def variants() -> dict[str, Variant]:
    """``qp-elastic/elastiqp``: the solver that is made for it."""
    summary = "elastic QP (1-norm of the miss) by dual active set"
    missing = solvers.missing("elastiqp")
    return {
        "qp-elastic/elastiqp": Variant(key="elastiqp", summary=summary, missing=missing, solver="elastiqp")
    }


def build(solver: str, vehicle: Vehicle) -> "Elastic":
    """Prepare min 1/2 f'Hf + PRICE sum_i |T P f - tau|_i / |T_i| within limits."""
    return Elastic(vehicle)


class Elastic(Saturating):
    """The allocator; ``pose`` and ``solve`` are its two stages (``alloc.plugin.TwoStage``).

    Where the solver gives no answer, T* tau is cut at the limits.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        """Set the problem up; only its right sides change from call to call."""
        k, self._working = vehicle.k, vehicle.working
        m = len(self._working)
        rows = 1.0 / vehicle.row_lengths
        A, eye = rows[:, None] * vehicle.TP[:, self._working], np.eye(m)
        self._thrust, self._scale_of_b = vehicle.f_scale, rows / vehicle.f_scale
        H = vehicle.H[np.ix_(self._working, self._working)] / vehicle.H.max()
        left = np.vstack([A, -A, eye, -eye])
        prices = np.repeat([PRICE, PRICE_OF_LIMITS], [2 * k, 2 * m])
        super().__init__(vehicle, FORMULATION, self._mend, start=np.zeros((vehicle.n, k)))
        self.solve = prepare_rows(H, left, *self.pose(np.zeros(k)), prices, level="tight")
        self._inverse = generalized_inverse(vehicle)
        self._alone = Lock()  # the model holds one problem

    def pose(
        self, tau: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None
    ) -> tuple[FloatArray]:
        """Right sides (2k + 2m,): the wrench from above and below, then limits of what works [-]."""
        low, high = self._bounds[:2] if f_min is None or f_max is None else (f_min, f_max)
        b = tau * self._scale_of_b
        sides = high[self._working] / self._thrust, low[self._working] / -self._thrust
        return (np.concatenate([b, -b, *sides]),)

    def _mend(self, tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        with self._alone:
            x, status, steps, _ = self.solve(*self.pose(tau, limits.low, limits.high))
        if status is not Status.SOLVED:
            return self._inverse.dot(tau).tolist(), steps
        for i, value in zip(self._working.tolist(), x.tolist(), strict=True):
            f[i] = value * self._thrust
        return f, steps
