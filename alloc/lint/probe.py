"""Probe table: the effect of each thruster alone, to be ticked at the pool."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from alloc.vehicle import Vehicle
from alloc.vehicle.frame import effect
from alloc.vehicle.geometry import MOMENTS, unit

SHARE = 0.1
"""Share of full thrust ahead with which each thruster is tried: enough to see, little enough to hold."""
SEEN = 0.15
"""Share of a thruster's largest effect, with axes in proportion to what the vehicle can do, from which on an
effect is put into words; so is a force or moment that is no smaller than another one in words."""
NOISE = 1e-9
"""Share of that largest effect below which one is rounding, as cos 90 deg leaves it."""
SMALL = (
    f"small: hardly seen, below {100 * SEEN:.0f} % of the thruster's largest effect, each axis in proportion"
    " to what the vehicle can do there"
)
"""The line below a table with such effects."""


class Probe(NamedTuple):
    """One thruster alone, a little ahead.

    Attributes
    ----------
    thruster : what it is called
    thrust : with which it is tried [N]
    effects : what the vehicle should do, the plainest first: axis, force or moment [N, N m], words
    small : effects that are hardly seen, below SEEN: axis, force or moment [N, N m]
    """

    thruster: str
    thrust: float
    effects: tuple[tuple[str, float, str], ...]
    small: tuple[tuple[str, float], ...] = ()

    @property
    def words(self) -> str:
        """The effects in words: ``pushes down; turns the bow to port``."""
        return "; ".join(words for _, _, words in self.effects) or "nothing that is controlled"

    @property
    def numbers(self) -> str:
        """The effects in numbers and the vehicle's frame: ``heave +4.1 N; small: roll +0.1 N m``."""
        told, small = (
            ", ".join(f"{axis} {value:+.2g} {unit(axis)}" for axis, value, *_ in each)
            for each in (self.effects, self.small)
        )
        return f"{told}; small: {small}" if small else told


def probes(vehicle: Vehicle) -> list[Probe]:
    """Effect of each working thruster alone, with a tenth of its thrust ahead.

    A thruster that only pushes astern is tried with a tenth of that.
    """
    found = []
    moments = np.isin(vehicle.dof, MOMENTS)
    for i in vehicle.working.tolist():
        thrust = SHARE * float(vehicle.f_max[i] if vehicle.f_max[i] > 0 else vehicle.f_min[i])
        wrench = vehicle.TP[:, i] * thrust
        shares = np.abs(wrench) / vehicle.row_lengths
        plain = shares > SEEN * shares.max()
        for kind in (moments, ~moments):
            least = np.abs(wrench[plain & kind]).min(initial=np.inf)
            plain |= kind & (np.abs(wrench) >= (1.0 - NOISE) * least)
        order = np.argsort(-shares, kind="stable").tolist()
        effects = [(k, vehicle.dof[k], float(wrench[k])) for k in order if shares[k] > NOISE * shares.max()]
        found.append(
            Probe(
                vehicle.called(i),
                thrust,
                tuple(
                    (axis, value, effect(axis, vehicle.frame, value))
                    for k, axis, value in effects
                    if plain[k]
                ),
                tuple((axis, value) for k, axis, value in effects if not plain[k]),
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
    return "\n".join([*lines, *([SMALL] if any(probe.small for probe in found) else [])])


def _row(probe: Probe) -> tuple[str, str, str, str]:
    return probe.thruster, f"{probe.thrust:+.3g} N", probe.words, probe.numbers
