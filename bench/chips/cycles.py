"""Cycles of the costliest of some calls, as an interval, where a processor's timing is published."""

import numpy as np

from alloc.allocation import FloatArray
from bench.chips.count import CallCounts
from bench.chips.image import Image
from bench.chips.interval import Cycles, Unpublished
from bench.chips.trace import trace

TRACED = 20
"""Calls that are followed: those that take most instructions."""


def cycles(image: Image, calls: FloatArray, counted: CallCounts) -> Cycles | None:
    """At least and at most so many cycles of the costliest call; None where that is not known.

    ``calls`` (N, width) are those that were ``counted``. The costliest takes at least what any of them
    takes at least, and at most what any takes at most.
    """
    model = image.target.cycles
    if model is None:
        return None
    some = np.argsort(-counted.instructions, kind="stable")[:TRACED]
    try:
        spans = model(trace(image, calls[some], counted.instructions[some]))
    except Unpublished:
        return None
    return Cycles(max(s.low for s in spans), max(s.high for s in spans)) if spans else None
