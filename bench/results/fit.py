"""The control loop that has to be served, and what can be said of serving it."""

from dataclasses import dataclass
from enum import IntEnum


class Fit(IntEnum):
    """Whether a method fits the time it may take, best first."""

    FITS = 0
    WITHOUT_TAIL = 1
    """Its median fits; its tail does not, or is not known."""
    MAY_FIT = 2
    """Only a band is known for its time, and the limit lies within."""
    DOES_NOT_FIT = 3
    UNKNOWN = 4

    def __str__(self) -> str:
        """In words."""
        return ("fits", "fits without tail", "may fit", "does not fit", "unknown")[self]


@dataclass(frozen=True)
class Loop:
    """The control loop that has to be served.

    Attributes
    ----------
    rate_hz : how often
    budget : share of the period that allocation may take [-]
    deadline_us : time that it may take, in place of a budget
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
        """The rate at which a call of that length [us] just takes what the budget, or the period, allows."""
        return (self.budget if self.deadline_us is None else 1.0) * 1e6 / call_us
