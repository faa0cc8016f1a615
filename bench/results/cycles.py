"""Time from counts of instructions: a band, because instructions are not cycles and no cycle was measured.

Where a record has cycles of a call by published timings, those are the band (``Counted.cpi``).
"""

from dataclasses import dataclass


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


PUBLISHED = "by published timings at zero wait states (docs/embedded.md)"
"""Basis of a band whose cycles come out of the record."""

CPI = {
    "cortex-m4f": Cpi(
        1.0,
        3.0,
        "one instruction at a time; published at zero wait states: 1 cycle to add, multiply or compare, 2 to"
        " load, 3 to multiply and add (TI SWCU192, tables 3-25 and 3-27). Flash wait states come on top",
    ),
    "cortex-m7": Cpi(
        0.5,
        4.0,
        "Arm publishes none; assumed: at best two at a time, at worst each waits 4 cycles for a"
        " double-precision sum before it (latency in LLVM's ARMScheduleM7.td). Cache misses come on top",
    ),
    "aarch64": Cpi(
        0.5,
        4.0,
        "there is none for all cores; assumed: at best two at a time, at worst each waits 4 cycles for a sum"
        " before it, as on a small core in order. Cache misses come on top",
    ),
}
"""Assumptions by target; a target without one has no band."""


def seconds(instructions: float, clock_hz: float, cpi: Cpi) -> tuple[float, float]:
    """Least and most time [s] that ``instructions`` take at a clock, under the assumption ``cpi``."""
    return instructions * cpi.low / clock_hz, instructions * cpi.high / clock_hz


def share(instructions: float, clock_hz: float, rate_hz: float, cpi: Cpi) -> tuple[float, float]:
    """Least and most share of the control period 1 / ``rate_hz`` that a call takes [-]."""
    low, high = seconds(instructions, clock_hz, cpi)
    return low * rate_hz, high * rate_hz
