"""Shares of the control period from counts of instructions: bands, because instructions are not cycles."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from bench.results.cycles import CPI, Cpi, share
from bench.results.emulated import EmulatedRow
from bench.results.fit import Fit, Loop


@dataclass(frozen=True, kw_only=True)
class Band:
    """What one kernel takes of the control period on one processor, at a clock.

    Attributes
    ----------
    vehicle, target, method, scalar : what names the kernel and the processor
    instructions : count of the most costly call over every demand set, the search for it included
    low, high : share of the period [-]
    fit : whether that fits the control loop
    agrees : whether all of the kernel's answers were right
    missed : demand sets whose count failed; any may hold a more costly call, so then nothing is known to fit
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

    ``cpi`` holds the assumptions by target.
    """
    groups: dict[tuple[str, str, str, str], list[EmulatedRow]] = {}
    for row in rows:
        if row.emulated.target in cpi:
            key = (row.emulated.vehicle, row.emulated.target, row.emulated.method, row.emulated.scalar)
            groups.setdefault(key, []).append(row)
    made = []
    for (vehicle, target, method, scalar), group in groups.items():
        counted = [row for row in group if row.worst is not None]
        if not counted:
            continue
        missed = tuple(row.emulated.demands for row in group if row.worst is None)
        worst = max(row.worst or 0 for row in counted)
        low, high = share(worst, clock_hz, loop.rate_hz, cpi[target])
        limit = loop.limit_share
        fit = Fit.FITS if high <= limit else Fit.MAY_FIT if low <= limit else Fit.DOES_NOT_FIT
        if missed and fit != Fit.DOES_NOT_FIT:
            fit = Fit.UNKNOWN
        band = Band(
            vehicle=vehicle,
            target=target,
            method=method,
            scalar=scalar,
            instructions=worst,
            low=low,
            high=high,
            fit=fit,
            agrees=all(row.emulated.agrees for row in counted),
            missed=missed,
        )
        made.append(band)
    return sorted(made, key=lambda band: (band.vehicle, band.target, band.instructions, band.scalar))
