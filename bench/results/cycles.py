"""Time from counts of instructions: a band, because instructions are not cycles and no cycle was measured.

Where a record has cycles of a call by published timings, those are the band (``Counted.cpi``).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from bench.record import Processor


@dataclass(frozen=True)
class Cpi:
    """How many cycles an instruction takes, averaged over a call.

    Attributes
    ----------
    low, high : least and most cycles per instruction
    basis : why these are assumed
    """

    low: float
    high: float
    basis: str

    def __str__(self) -> str:
        """The band and its basis, as reports show them."""
        return f"{self.low:g} to {self.high:g}; {self.basis}"


PUBLISHED = "by published timings at zero wait states (docs/counting.md)"
"""Basis of a band whose cycles come out of the record."""


def assumed(processors: Iterable[Processor]) -> Mapping[str, Cpi]:
    """Cycles an instruction that a record assumes, by processor; a processor without has no band."""
    return {one.name: Cpi(one.cpi[0], one.cpi[1], one.basis) for one in processors if len(one.cpi) == 2}


def seconds(instructions: float, clock_hz: float, cpi: Cpi) -> tuple[float, float]:
    """Least and most time [s] that ``instructions`` take at a clock, under the assumption ``cpi``."""
    return instructions * cpi.low / clock_hz, instructions * cpi.high / clock_hz


def share(instructions: float, clock_hz: float, rate_hz: float, cpi: Cpi) -> tuple[float, float]:
    """Least and most share of the control period 1 / ``rate_hz`` that a call takes [-]."""
    low, high = seconds(instructions, clock_hz, cpi)
    return low * rate_hz, high * rate_hz
