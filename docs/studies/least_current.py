"""Bounds of shares and currents below a cap, of many thrusts at once and without a linear program.

A *price* y (k,) says what a unit of wrench is worth [A/N, A/(N m)]. Whatever makes a wrench w draws at least
y . w - gain(y) [A], where the gain is the most by which y . T P x exceeds the current of any x within limits:
a sum over thrusters, each by itself. So none of the same direction within a cap is larger than w by more
than (cap + gain(y)) / (y . w). Any price bounds all wrenches, and the best of many is near each.
"""

from dataclasses import dataclass

import numpy as np

from alloc import Vehicle
from alloc.allocation import BoolArray, FloatArray
from alloc.vehicle.current import Draw, Pieces, PowerLaw
from alloc.vehicle.limits import Interval

AT_END = 1e-7
"""Distance from an end of a straight piece within which a thrust lies on it [N]."""
LEANING = 1e-4
"""Weight of a slope that the worth of a thrust need not have."""
SHARED = 2_000
"""Prices by which all wrenches are bounded, beside each by its own."""
ROWS = 4_096
"""Wrenches that are bounded by all of these at once, for the memory that this takes."""


@dataclass(frozen=True)
class Capped:
    """Vehicle within limits (n,) [N] and a cap [A], with what its thrusters draw."""

    vehicle: Vehicle
    limits: Interval
    draw: Draw
    cap: float

    def bounds(self, F: FloatArray, lean: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Least share of thrusts (N, n) over the largest, and most current over the least, each (N,) [-].

        Prices are those of ``lean``: the nearer these are to thrusts of least current that make the same, the
        tighter are the bounds.
        """
        y, wrenches = self.prices(lean), F @ self.vehicle.strong.TP.T
        gain, worth = self.gains(y), np.sum(wrenches * y, axis=1)
        shares, least = worth / (self.cap + gain), worth - gain
        for first in range(0, len(F), ROWS):
            rows = slice(first, first + ROWS)
            worth = wrenches[rows] @ y[:SHARED].T
            shares[rows] = np.maximum(shares[rows], np.max(worth / (self.cap + gain[:SHARED]), axis=1))
            least[rows] = np.maximum(least[rows], np.max(worth - gain[:SHARED], axis=1))
        amps = self.draw.amps(F).sum(axis=1)
        return shares, np.divide(amps, least, out=np.full(len(F), np.inf), where=least > 0.0)

    def prices(self, F: FloatArray) -> FloatArray:
        """Prices (N, k) by which thrusts (N, n) would be those of least current, as nearly as there are any.

        At least current a thrust that is at no limit, and at no end of a straight piece, is worth its slope;
        the others count for prices that these leave open.
        """
        tangents = self.draw.tangents
        slopes = np.array([[at(x)[1] for at, x in zip(tangents, f, strict=True)] for f in F.tolist()])
        weights = np.ones(F.shape)
        for curve, columns in self.draw.groups:
            for i in columns.tolist():
                weights[near(self.ends(curve, i), F[:, i]), i] = LEANING
        maps = np.linalg.pinv(self.vehicle.strong.TP.T * weights[:, :, None])
        y: FloatArray = np.einsum("imn,in->im", maps, weights * slopes)
        return y

    def gains(self, y: FloatArray) -> FloatArray:
        """Most by which the worth of thrusts exceeds their current, within limits, by price: (N,) [A]."""
        worth, gains = y @ self.vehicle.strong.TP, np.zeros(len(y))
        for curve, columns in self.draw.groups:
            for i in columns.tolist():
                f = self.ends(curve, i)
                most = np.max(np.outer(worth[:, i], f) - curve.draws(f), axis=1)
                if isinstance(curve, PowerLaw) and curve.power > 1.0:
                    f = steepest(curve, worth[:, i]).clip(f[0], f[-1])
                    most = np.maximum(most, worth[:, i] * f - curve.draws(f))
                gains += most
        return gains

    def ends(self, curve: Pieces | PowerLaw, i: int) -> FloatArray:
        """Ends of a thruster's straight pieces, rising, from limit to limit [N]; a law has limits and 0."""
        low, high = self.limits[0][i], self.limits[1][i]
        return np.unique(
            np.append(curve.f if isinstance(curve, Pieces) else 0.0, [low, high]).clip(low, high)
        )


def near(ends: FloatArray, f: FloatArray) -> BoolArray:
    """Mask of thrusts (N,) within AT_END of one of the rising ends."""
    after = ends.searchsorted(f).clip(1, len(ends) - 1)
    mask: BoolArray = np.minimum(np.abs(f - ends[after - 1]), np.abs(f - ends[after])) <= AT_END
    return mask


def steepest(law: PowerLaw, worth: FloatArray) -> FloatArray:
    """Thrust (N,) [N] at which the current of a law rises by so much (N,) [A/N]."""
    factor = law.power * np.where(worth < 0.0, law.astern, law.ahead)
    with np.errstate(divide="ignore"):
        f: FloatArray = np.sign(worth) * (np.abs(worth) / factor) ** (1.0 / (law.power - 1.0))
    return f
