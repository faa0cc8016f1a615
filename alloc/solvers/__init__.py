"""One file, one solver: a function of a QP that returns ``b -> Answer``. Found by its file name."""

from math import nan
from typing import Literal, NamedTuple

from alloc.allocation import FloatArray, Status

Start = Literal["cold", "reused", "warm"]
"""cold: new object each call; reused: same object, new b; warm: reused, the last answer is the guess."""
Level = Literal["default", "tight"]
"""default: the solver's own settings; tight: settings for f within 1e-6 of the optimum."""


class Answer(NamedTuple):
    """A solver's claim about one b: x in the units of the QP (not checked), in its own words otherwise."""

    x: FloatArray
    status: Status
    iterations: int = 0
    solver_s: float = nan
