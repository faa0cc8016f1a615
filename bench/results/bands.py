"""From instructions to shares of the control period: bands, since instructions are not cycles."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from bench.results.cycles import CPI, Cpi, share
from bench.results.emulated import EmulatedRow
from bench.results.fit import Fit, Loop


@dataclass(frozen=True)
class Band:
    """What one kernel takes of the control period on one processor, at a clock.

    Attributes
    ----------
    instructions : of the most costly call over every demand set, the search for it included
    low, high : share of the period [-]
    agrees : whether all of its answers were right
    missed : demand sets whose count failed, any of which may hold a call more costly; then nothing is
        known to fit
    """

    vehicle: str
    target: str
    method: str
    scalar: str
    instructions: int
    low: float
    high: float
    fit: Fit
    agrees: bool
    missed: tuple[str, ...] = ()


def bands(
    rows: Iterable[EmulatedRow], clock_hz: float, loop: Loop, cpi: Mapping[str, Cpi] = CPI
) -> list[Band]:
    """A band for each kernel and processor that has an assumption on cycles, cheapest first.

    ``cpi`` is the assumption by target.
    """
    groups: dict[tuple[str, str, str, str], list[EmulatedRow]] = {}
    for row in rows:
        if row.is_.target in cpi:
            key = (row.is_.vehicle, row.is_.target, row.is_.method, row.is_.scalar)
            groups.setdefault(key, []).append(row)
    found = []
    for key, group in groups.items():
        counted = [row for row in group if row.worst is not None]
        if not counted:
            continue
        missed = tuple(row.is_.demands for row in group if row.worst is None)
        worst = max(row.worst or 0 for row in counted)
        low, high = share(worst, clock_hz, loop.rate_hz, cpi[key[1]])
        limit = loop.limit_share
        fit = Fit.FITS if high <= limit else Fit.MAY_FIT if low <= limit else Fit.DOES_NOT_FIT
        if missed and fit != Fit.DOES_NOT_FIT:
            fit = Fit.UNKNOWN
        agrees = all(row.is_.agrees for row in counted)
        found.append(Band(*key, worst, low, high, fit, agrees, missed))
    return sorted(found, key=lambda band: (band.vehicle, band.target, band.instructions, band.scalar))
