"""Cycles of the costliest of some calls, as intervals: of the processor, and of boards that have it."""

import numpy as np

from alloc.allocation import FloatArray
from bench.chips.boards import boards
from bench.chips.count import CallCounts
from bench.chips.executed import Trace
from bench.chips.flash import Flash, touched, waiting
from bench.chips.image import Image
from bench.chips.interval import Cycles, Unpublished
from bench.chips.trace import trace

TRACED = 20
"""Calls that are followed: those that take most instructions."""


def cycles(image: Image, calls: FloatArray, counted: CallCounts) -> dict[str, Cycles]:
    """At least and at most so many cycles of the costliest call, by whose they are; empty where not known.

    Under the processor's name stand those without wait states, under a board's those with its flash.
    ``calls`` (N, width) are those that were ``counted``. The costliest takes at least what any of them
    takes at least, and at most what any takes at most.
    """
    model = image.target.cycles
    if model is None:
        return {}
    some = np.argsort(-counted.instructions, kind="stable")[:TRACED]
    followed = trace(image, calls[some], counted.instructions[some])
    try:
        spans = model(followed)
    except Unpublished:
        return {}
    if not spans:
        return {}
    found = {image.target.name: _costliest(spans)}
    for board in boards(image.target.name):
        waits = _waits(followed, board.flash)
        behind = [Cycles(s.low + w.low, s.high + w.high) for s, w in zip(spans, waits, strict=True)]
        found[board.name] = _costliest(behind)
    return found


def _costliest(spans: list[Cycles]) -> Cycles:
    return Cycles(max(span.low for span in spans), max(span.high for span in spans))


def _waits(followed: Trace, flash: Flash) -> list[Cycles]:
    """Waits of each call for the flash; calls that took the same path wait alike."""
    known: dict[bytes, Cycles] = {}
    found = []
    for i, call in enumerate(followed.calls):
        key = call.tobytes() + followed.loads[i].tobytes()
        if key not in known:
            known[key] = waiting(flash, *touched(flash, followed.addresses(i), followed.loads[i]))
        found.append(known[key])
    return found
