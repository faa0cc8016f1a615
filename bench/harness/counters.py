"""Counters of what disturbed a measurement on this machine."""

import os
from dataclasses import dataclass
from pathlib import Path

from bench.record import Quiet

_CPU = Path("/sys/devices/system/cpu")


@dataclass(frozen=True)
class Reading:
    """Counters of one core at one moment; None where this machine does not tell.

    Attributes
    ----------
    core : its number
    steal_ticks : time that the hypervisor took from it so far [1/100 s]
    throttled : thermal throttle events so far
    mhz : its frequency now [MHz]
    """

    core: int
    steal_ticks: int | None
    throttled: int | None
    mhz: float | None


def reading(core: int) -> Reading:
    """Read the counters of a core now."""
    return Reading(
        core=core,
        steal_ticks=_steal(core),
        throttled=_number(_CPU / f"cpu{core}/thermal_throttle/core_throttle_count"),
        mhz=_mhz(core),
    )


def between(before: Reading, after: Reading) -> Quiet:
    """Events from one reading to the next."""
    speeds = [mhz for mhz in (before.mhz, after.mhz) if mhz is not None]
    return Quiet(
        steal_ticks=_difference(before.steal_ticks, after.steal_ticks),
        throttled=_difference(before.throttled, after.throttled),
        load=load(),
        mhz=[min(speeds), max(speeds)] if speeds else None,
    )


def load() -> float | None:
    """The 1-minute load average, None where the system has none."""
    try:
        return round(os.getloadavg()[0], 2)
    except OSError:
        return None


def _difference(before: int | None, after: int | None) -> int | None:
    return None if before is None or after is None else after - before


def _steal(core: int) -> int | None:
    # The eighth number of a cpu line [ticks of 1/100 s] is the time that the hypervisor ran another guest.
    try:
        lines = Path("/proc/stat").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    fields = next((line.split() for line in lines if line.startswith(f"cpu{core} ")), [])
    return int(fields[8]) if len(fields) > 8 else None


def _mhz(core: int) -> float | None:
    khz = _number(_CPU / f"cpu{core}/cpufreq/scaling_cur_freq")
    return None if khz is None else khz / 1000


def _number(path: Path) -> int | None:
    try:
        return int(path.read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None
