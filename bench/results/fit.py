"""The control loop that a method must serve, and the verdicts on whether it does."""

from dataclasses import dataclass
from enum import IntEnum

LATE_SHARE = 0.001
"""Largest share of late calls of a method that fits: one in a thousand, as p99.9 is judged."""


class Fit(IntEnum):
    """Verdict on a method's time against the time it may take, best first."""

    FITS = 0
    WITHOUT_TAIL = 1
    """The median fits; the tail does not, or is not known."""
    MAY_FIT = 2
    """Only a band is known for the time, and the limit lies inside the band."""
    DOES_NOT_FIT = 3
    UNKNOWN = 4

    def __str__(self) -> str:
        """The verdict in words."""
        return ("fits", "median fits", "may fit", "does not fit", "unknown")[self]


@dataclass(frozen=True)
class Loop:
    """A control loop that a method must serve.

    Attributes
    ----------
    rate_hz : calls per second [Hz]
    budget : share of the period that allocation may take [-]
    deadline_us : time that allocation may take [us], in place of a budget
    """

    rate_hz: float
    budget: float = 0.1
    deadline_us: float | None = None

    @property
    def period_us(self) -> float:
        """Time from one call to the next [us]."""
        return 1e6 / self.rate_hz

    @property
    def limit_us(self) -> float:
        """Time that one call may take [us]."""
        return self.budget * self.period_us if self.deadline_us is None else self.deadline_us

    @property
    def limit_share(self) -> float:
        """Share of the period that one call may take [-]."""
        return self.limit_us / self.period_us

    def highest_rate_hz(self, call_us: float) -> float:
        """Highest rate [Hz] at which a call of ``call_us`` [us] keeps within the budget, or the period."""
        return (self.budget if self.deadline_us is None else 1.0) * 1e6 / call_us
