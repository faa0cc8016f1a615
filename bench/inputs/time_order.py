"""Messages of a log in the order of their times; two recordings in one file are refused."""

from pathlib import Path

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.errors import DemandError

LATE = 1.0
"""Messages that arrive later than others by up to this are put in order; a time further back is another one's
[s]."""


def in_order(path: Path, t: FloatArray) -> IndexArray:
    """The order (N,) of messages with times t [s].

    Raises DemandError where time goes back by more than LATE.
    """
    back = np.flatnonzero(np.diff(t) < -LATE)
    if back.size:
        before, behind = t[back[0] : back[0] + 2]
        raise DemandError(
            f"{path}: time goes back from {before:.6g} to {behind:.6g} s, as where a simulation was started"
            " again, or a clock was set; record each by itself, or cut it"
        )
    return np.argsort(t, kind="stable")
