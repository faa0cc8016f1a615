"""An estimate of another machine's times, from fixed work that was timed on both machines."""

from dataclasses import dataclass
from math import prod

from bench.record import NO_VEHICLE
from bench.record.canary import CanaryError, CanaryFile
from bench.results.rows import Run

WIDENING = 1.5
"""Factor by which the band is wider at either end than the canaries' ratios. The canaries are a Python loop
and a matrix product; a solver's code also depends on caches, compilers and instruction sets."""


@dataclass(frozen=True)
class Transfer:
    """How much longer calls take on the target than where the run was made.

    Attributes
    ----------
    low, high : ends of the band [-]
    centre : geometric mean of the canaries' ratios [-]
    machine : the target
    """

    low: float
    centre: float
    high: float
    machine: str


def transfer(run: Run, target: CanaryFile) -> Transfer:
    """The band by which times of a run change on the target; raises CanaryError without canaries."""
    here = {row.method: row.call_p50_us for row in run.rows if row.vehicle == NO_VEHICLE}
    ratios = [us / there for name, us in target.median_us.items() if (there := here.get(name))]
    if not ratios:
        raise CanaryError("this run holds none of the file's canaries; run again with this version")
    centre = prod(ratios) ** (1 / len(ratios))
    machine = str(target.machine.get("cpu") or "the target")
    return Transfer(min(ratios) / WIDENING, centre, max(ratios) * WIDENING, machine)
