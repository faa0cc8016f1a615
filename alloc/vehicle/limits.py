"""Limits that move: what a battery's voltage, the last thrusts and a blocked thruster leave of them."""

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray, real
from alloc.errors import DemandError, VehicleError

Interval = tuple[FloatArray, FloatArray]
"""f_min and f_max, (n,) each [N]."""


@dataclass(frozen=True, eq=False)
class Slew:
    """Rates at which thrusts may change.

    Attributes
    ----------
    up, down : (n,) largest rise and fall of each signed thrust [N/s]: one that spins up astern falls
    """

    up: FloatArray
    down: FloatArray

    def around(self, f: FloatArray, dt: float) -> Interval:
        """Interval that thrusts f (n,) [N] can reach within dt [s]: [f - down dt, f + up dt]."""
        return f - self.down * dt, f + self.up * dt


@dataclass(frozen=True, eq=False)
class VoltageTable:
    """Limits of the thrusters at each voltage of the battery, linear between the entries.

    Attributes
    ----------
    volts : (m,) rising [V]
    f_min, f_max : (m, n) limits at each of them [N]
    """

    volts: FloatArray
    f_min: FloatArray
    f_max: FloatArray

    def at(self, volts: float) -> Interval:
        """The limits at a voltage [V]; raises DemandError outside of the table, which can't tell."""
        if not self.volts[0] <= volts <= self.volts[-1]:
            raise DemandError(
                f"volts = {volts:g} lies outside of the table, which has {self.volts[0]:g} to"
                f" {self.volts[-1]:g} V; give a voltage within, or more of the table"
            )
        low, high = self.between(np.array([volts]))
        return low[0], high[0]

    def between(self, volts: FloatArray) -> Interval:
        """The limits (N, n) at voltages (N,) inside of the table [N]."""
        low, high = (
            np.column_stack([np.interp(volts, self.volts, column) for column in side.T])
            for side in (self.f_min, self.f_max)
        )
        return low, high


def of_a_moment(
    name: str,
    own: Interval,
    table: VoltageTable | None,
    slew: Slew | None,
    volts: float | None,
    f_previous: ArrayLike | None,
    dt: float | None,
) -> Interval:
    """A vehicle's ``own`` limits, intersected with those at a voltage and with those around the last thrusts.

    Raises as ``Vehicle.limits``; f_min exceeds f_max where nothing is left.
    """
    intervals = [own]
    if volts is not None:
        if table is None:
            raise VehicleError(f"{name}: has no limits by voltage; add 'volts' to its file", "volts")
        intervals.append(table.at(volts))
    if (f_previous is None) != (dt is None):
        raise DemandError("f_previous and dt say together how far thrusts may have moved; give both")
    if f_previous is not None and dt is not None:
        if slew is None:
            raise VehicleError(f"{name}: has no slew rates; add 'slew' [N/s] to its file", "slew")
        if not (isfinite(dt) and dt > 0):
            raise DemandError(f"dt = {dt:g} is no time since the last call; give seconds above 0")
        intervals.append(slew.around(thrusts(f_previous, len(own[0])), dt))
    lows, highs = zip(*intervals, strict=True)
    return np.max(lows, axis=0), np.min(highs, axis=0)


def thrusts(f: ArrayLike, n: int, name: str = "f_previous") -> FloatArray:
    """Thrusts f (n,) [N] as finite numbers; raises DemandError for anything else."""
    try:
        values = real(np.asarray(f))
    except (TypeError, ValueError, OverflowError) as error:
        raise DemandError(f"{name} is not an array of numbers ({error}); give n = {n} of them") from None
    if values.shape != (n,) or not np.isfinite(values).all():
        raise DemandError(
            f"{name} has shape {values.shape}, or holds NaN or infinity; give ({n},) finite thrusts [N]"
        )
    return values


def check_slew(slew: Slew, n: int) -> None:
    """Raise VehicleError unless there is a positive rate for each of n thrusters."""
    for side, rates in (("up", slew.up), ("down", slew.down)):
        if rates.shape != (n,) or not (np.isfinite(rates) & (rates > 0)).all():
            raise VehicleError(
                f"slew: {side} must be one positive number, or one for each of {n} thrusters [N/s]", "slew"
            )


def check_table(table: VoltageTable, n: int) -> None:
    """Raise VehicleError unless the voltages rise and each has limits of n thrusters that leave a thrust."""
    if len(table.volts) < 2 or not (np.diff(table.volts) > 0).all() or not table.volts[0] > 0:
        raise VehicleError("volts: give two or more different voltages above 0 V, lowest first", "volts")
    for low, high, volts in zip(table.f_min, table.f_max, table.volts, strict=True):
        if low.shape != (n,) or high.shape != (n,) or not (low <= high).all():
            raise VehicleError(
                f"volts: at {volts:g} V give [f_min, f_max], each one number or one for each of {n}"
                " thrusters, f_min not above f_max",
                "volts",
            )
