"""What each thruster alone should do to the vehicle, as a table to be ticked at the pool."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from alloc.vehicle import Vehicle
from alloc.vehicle.frame import effect
from alloc.vehicle.geometry import unit

SHARE = 0.1
"""Share of full thrust ahead with which each thruster is tried: enough to see, little enough to hold."""
SEEN = 0.15
"""Share of a thruster's largest effect, with axes in proportion to what the vehicle can do, that is told."""


class Probe(NamedTuple):
    """One thruster alone, a little ahead.

    Attributes
    ----------
    thruster : what it is called
    thrust : with which it is tried [N]
    effects : what the vehicle should do, the plainest first: axis, force or moment [N, N m], words
    """

    thruster: str
    thrust: float
    effects: tuple[tuple[str, float, str], ...]

    @property
    def words(self) -> str:
        """The effects in words: ``pushes down; turns the bow to port``."""
        return "; ".join(words for _, _, words in self.effects) or "nothing that is controlled"

    @property
    def numbers(self) -> str:
        """The effects in numbers and the vehicle's frame: ``heave +4.1 N, yaw -0.8 N m``."""
        return ", ".join(f"{axis} {value:+.2g} {unit(axis)}" for axis, value, _ in self.effects)


def probes(vehicle: Vehicle) -> list[Probe]:
    """What each working thruster should do alone, with a tenth of its thrust ahead.

    A thruster that only pushes astern is tried with a tenth of that.
    """
    found = []
    for i in vehicle.working.tolist():
        thrust = SHARE * float(vehicle.f_max[i] if vehicle.f_max[i] > 0 else vehicle.f_min[i])
        wrench = vehicle.TP[:, i] * thrust
        shares = np.abs(wrench) / vehicle.row_lengths
        told = [k for k in np.argsort(-shares, kind="stable").tolist() if shares[k] > SEEN * shares.max()]
        found.append(
            Probe(
                vehicle.called(i),
                thrust,
                tuple(
                    (axis, float(wrench[k]), effect(axis, vehicle.frame, float(wrench[k])))
                    for k, axis in ((k, vehicle.dof[k]) for k in told)
                ),
            )
        )
    return found


def as_text(found: Sequence[Probe]) -> str:
    """The table as text, a line each with a box to tick."""
    rows = [("thruster", "thrust", "what it should do", "in its frame"), *map(_row, found)]
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    lines = [
        "  ".join((box, *(cell.ljust(width) for cell, width in zip(row, widths, strict=True)))).rstrip()
        for box, row in zip(("   ", *["[ ]"] * len(found)), rows, strict=True)
    ]
    return "\n".join(lines)


def _row(probe: Probe) -> tuple[str, str, str, str]:
    return probe.thruster, f"{probe.thrust:+.3g} N", probe.words, probe.numbers
