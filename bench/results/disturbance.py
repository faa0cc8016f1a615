"""Disturbances of the machine while a cell was measured, judged from the record."""

from collections.abc import Iterable
from statistics import median

from bench.record import Cell, Record

INTERRUPTED_SHARE = 0.1
"""Share of batches that may have an involuntary switch: up to one in ten does not move their median."""
STEAL_TICKS = 2
"""Ticks of 10 ms taken by the hypervisor that disturb; a single tick may be the clock's own rounding."""
SLOWEST_SHARE = 0.9
"""Lowest clock frequency over the highest; a lower ratio means a governor or a hot core."""
DRIFT = 0.1
"""Change of the fixed canary against the run's median; between processes it repeats within 2 %."""


def canary_median_ns(record: Record) -> float | None:
    """Median time of the run's fixed canary [ns], None without one."""
    times = [cell.canary_ns for cell in record.cells if cell.canary_ns is not None]
    return float(median(times)) if times else None


def disturbances(cells: Iterable[Cell], usual_canary_ns: float | None, cores: int | None) -> tuple[str, ...]:
    """Names of what disturbed any of the cells; empty where the machine was quiet."""
    names = (name for cell in cells for name in _disturbances(cell, usual_canary_ns, cores))
    return tuple(dict.fromkeys(names))


def _disturbances(cell: Cell, usual_canary_ns: float | None, cores: int | None) -> list[str]:
    quiet, names = cell.quiet, []
    interrupted = sum(batch.switches > 0 for batch in cell.batches)
    if interrupted > INTERRUPTED_SHARE * len(cell.batches):
        names.append("involuntary switches")
    if usual_canary_ns and cell.canary_ns and abs(cell.canary_ns / usual_canary_ns - 1) > DRIFT:
        names.append("canary drift")
    if quiet is None:
        return names
    if (quiet.steal_ticks or 0) >= STEAL_TICKS:
        names.append("steal")
    if quiet.throttled:
        names.append("throttled")
    if quiet.mhz and min(quiet.mhz) < SLOWEST_SHARE * max(quiet.mhz):
        names.append("frequency")
    if quiet.load is not None and cores and quiet.load > cores:
        names.append("load")
    return names
