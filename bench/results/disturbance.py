"""Was the machine quiet while a cell was measured? The verdict, from what the record holds."""

from collections.abc import Iterable
from statistics import median

from bench.record import Cell, Record

INTERRUPTED_SHARE = 0.1
"""Batches with an involuntary switch: up to one in ten does not move their median."""
STEAL_TICKS = 2
"""Ticks of 10 ms taken by the hypervisor; a single one may be the clock's own rounding."""
SLOWEST_SHARE = 0.9
"""Lowest clock frequency over the highest; less is a governor or a hot core at work."""
DRIFT = 0.1
"""Change of the fixed canary against the run's median; between processes it repeats within 2 %."""


def canary_median_ns(record: Record) -> float | None:
    """The run's usual time of the canary [ns]."""
    times = [cell.canary_ns for cell in record.cells if cell.canary_ns is not None]
    return float(median(times)) if times else None


def disturbances(cells: Iterable[Cell], usual_canary_ns: float | None, cores: int | None) -> tuple[str, ...]:
    """What disturbed any of these cells, by name; empty where the machine was quiet."""
    found: dict[str, None] = {}
    for cell in cells:
        found |= dict.fromkeys(_of(cell, usual_canary_ns, cores))
    return tuple(found)


def _of(cell: Cell, usual_canary_ns: float | None, cores: int | None) -> list[str]:
    quiet, found = cell.quiet, []
    interrupted = sum(batch.switches > 0 for batch in cell.batches)
    if interrupted > INTERRUPTED_SHARE * len(cell.batches):
        found.append("involuntary switches")
    if usual_canary_ns and cell.canary_ns and abs(cell.canary_ns / usual_canary_ns - 1) > DRIFT:
        found.append("canary drift")
    if quiet is None:
        return found
    if (quiet.steal_ticks or 0) >= STEAL_TICKS:
        found.append("steal")
    if quiet.throttled:
        found.append("throttled")
    if quiet.mhz and min(quiet.mhz) < SLOWEST_SHARE * max(quiet.mhz):
        found.append("frequency")
    if quiet.load is not None and cores and quiet.load > cores:
        found.append("load")
    return found
