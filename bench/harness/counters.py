"""Counters of what disturbed a measurement on this machine."""

import os
from collections.abc import Callable
from pathlib import Path

from bench.record import Quiet

_CPU = Path("/sys/devices/system/cpu")


def quiet_since(core: int) -> Callable[[], Quiet]:
    """Function that says what has disturbed this core from now on, None where this machine does not tell."""
    steal, throttled, mhz = _steal(core), _throttled(core), _mhz(core)

    def quiet() -> Quiet:
        speeds = [each for each in (mhz, _mhz(core)) if each is not None]
        return Quiet(
            steal_ticks=_difference(steal, _steal(core)),
            throttled=_difference(throttled, _throttled(core)),
            load=load(),
            mhz=[min(speeds), max(speeds)] if speeds else None,
        )

    return quiet


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


def _throttled(core: int) -> int | None:
    return _number(_CPU / f"cpu{core}/thermal_throttle/core_throttle_count")


def _mhz(core: int) -> float | None:
    khz = _number(_CPU / f"cpu{core}/cpufreq/scaling_cur_freq")
    return None if khz is None else khz / 1000


def _number(path: Path) -> int | None:
    try:
        return int(path.read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None
