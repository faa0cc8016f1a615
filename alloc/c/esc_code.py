"""The names, types and tables that the C from thrusts to the commands of ESCs is written with."""

from dataclasses import dataclass

import numpy as np

from alloc.c.call import function_name
from alloc.c.recipe import Recipe
from alloc.errors import NotApplicable, VehicleError
from alloc.program import Scalar, Where
from alloc.program.literal import number
from alloc.vehicle import Vehicle
from alloc.vehicle.esc import SPARE


@dataclass(frozen=True, eq=False)
class EscCode:
    """Parts of the C between a kernel and the ESCs.

    Attributes
    ----------
    vehicle, scalar, limits : as of the kernel that it stands behind
    levels : how many shares that writes
    name : of the kernel
    """

    vehicle: Vehicle
    scalar: Scalar
    limits: Where
    levels: int
    name: str

    @property
    def command(self) -> str:
        """The C type of a command: an integer where neutral, range and step are."""
        escs = self.vehicle.esc
        if not all(esc.whole for esc in escs):
            return self.scalar
        return integers(max(abs(end) for esc in escs for end in (esc.low, esc.high)))

    def parameters(self, *, tau: bool) -> str:
        """The parameters of NAME_to_esc, which begin with tau, or of NAME_esc, which begin with f."""
        n, scalar = self.vehicle.n, self.scalar
        given = [f"const {scalar} {f'tau[{self.vehicle.k}]' if tau else f'f[{n}]'}"]
        given += self.call_limits
        given += ["int fault"] * tau + [f"{scalar} volts"]
        given += [f"{self.command} command[{n}]", f"{scalar} f_made[{n}]"]
        return ", ".join([*given, *[f"{scalar} share[{self.levels}]"] * (tau and self.levels > 0)])

    @property
    def call_limits(self) -> list[str]:
        """The parameters of limits; none where they stand in the C."""
        sides = ("f_min", "f_max") if self.limits == "call" else ()
        return [f"const {self.scalar} {side}[{self.vehicle.n}]" for side in sides]

    @property
    def alike(self) -> bool:
        """True if one pair of limits stands in the C, for all thrusters, with 0 between them."""
        low, high = self.vehicle.f_min, self.vehicle.f_max
        same = np.ptp(low) == np.ptp(high) == 0.0
        return self.limits == "fixed" and bool(same and low[0] <= 0 <= high[0])

    @property
    def stops(self) -> bool:
        """True if each thruster may stand still in every call."""
        low, high = self.vehicle.f_min, self.vehicle.f_max
        return self.limits == "fixed" and bool(((low <= 0) & (high >= 0)).all())

    @property
    def by_volts(self) -> bool:
        """True if some curve has more than one voltage."""
        return any(len(esc.volts) > 1 for esc in self.vehicle.esc)

    @property
    def wire(self) -> dict[str, list[str]]:
        """Command of neutral of each thruster, and the size of a step, as literals."""
        columns = {
            "neutral": [esc.neutral for esc in self.vehicle.esc],
            "by": [-esc.step if esc.reversed else esc.step for esc in self.vehicle.esc],
        }
        return {
            name: [self(x) if self.command == self.scalar else f"{x:.0f}" for x in values]
            for name, values in columns.items()
        }

    def __call__(self, value: float) -> str:
        """The literal of a number."""
        return number(value, self.scalar)


def integers(largest: float) -> str:
    """The C type of integers up to that size."""
    return "int16_t" if largest <= np.iinfo(np.int16).max else "int32_t"


def last_metre(vehicle: Vehicle, kernel: Recipe, scalar: Scalar, limits: Where) -> EscCode:
    """Parts of the C behind a kernel.

    Raises VehicleError for a vehicle without ``esc``, NotApplicable where the kernel says shares within fixed
    limits that its ESCs do not reach: thrusts that are cut afterwards deliver other shares.
    """
    if not vehicle.esc:
        raise VehicleError(f"{vehicle.name}: has no ESCs; add 'esc' to its file", "esc")
    levels = kernel.levels(vehicle)
    if limits == "fixed" and levels and (short := _short(vehicle)):
        raise NotApplicable(
            f"{vehicle.name}: {short} for shares of {kernel.name} within fixed limits; give --limits call,"
            " which are cut at what each voltage makes"
        )
    return EscCode(vehicle, scalar, limits, levels, function_name(vehicle, kernel.name, scalar, limits))


def _short(vehicle: Vehicle) -> str:
    """The first thruster whose ESC does not reach its limits at some voltage, in words; empty for none."""
    volts = np.unique(np.concatenate([esc.volts for esc in vehicle.esc]))
    low, high = vehicle.esc_limits(volts)
    lost = np.maximum(low - vehicle.f_min, vehicle.f_max - high) > SPARE * vehicle.f_scale
    if not lost.any():
        return ""
    row, i = np.argwhere(lost)[0].tolist()
    at = "" if np.isnan(volts[row]) else f" at {volts[row]:g} V"
    return (
        f"the ESC of {vehicle.called(i)} makes {low[row, i]:.4g} … {high[row, i]:.4g} N{at}, expected"
        f" {vehicle.f_min[i]:g} … {vehicle.f_max[i]:g} N"
    )
