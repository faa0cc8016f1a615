"""Many attainable demands answered by a program, and how far rounding took them."""

from typing import Any, NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.allocation import BoolArray, FloatArray
from alloc.program import Evaluated, Node, Program, Scalar, alike, answered, values
from bench.demands.corners import attainable
from bench.proof.subject import ANSWERED

CHUNK = 10_000
"""Demands at a time: so many values of every operation fit a processor's cache."""
KINDS = {"double": (np.float64, np.longdouble), "float": (np.float32, np.float64)}
"""The scalar, and what the formula is calculated in beside it."""


class Seen(NamedTuple):
    """Largest errors seen.

    Attributes
    ----------
    error : largest |f - f in real numbers| of all that were answered and took the same branches in both [N]
    flipped : largest of those that took others [N]
    flips : how many did
    answered, demands : how many of them
    """

    error: float
    flipped: float
    flips: int
    answered: int
    demands: int


def seen(
    program: Program,
    vehicle: Vehicle,
    scalar: Scalar,
    exact: dict[Node, float],
    demands: int,
) -> Seen:
    """Answer so many seeded attainable demands, and hold each answer against the formula's."""
    rng = np.random.default_rng(2004)
    narrow, wide = KINDS[scalar]
    error = flipped = 0.0
    flips = written = 0
    limits = (("f_min", vehicle.f_min), ("f_max", vehicle.f_max))
    for begin in range(0, demands, CHUNK):
        count = min(CHUNK, demands - begin)
        tau = attainable(vehicle, rng, count).astype(narrow)
        ends = {side: np.repeat(each[:, None], count, axis=1) for side, each in limits}
        made = values(program, {"tau": tau, **ends}, narrow)
        got = answered(program, made, count)
        writes = np.isin(got.status, ANSWERED)
        written += int(writes.sum())
        true = values(program, {"tau": tau, **ends}, wide, exact)
        difference, same = apart(program, got, made, true)
        error = max(error, float(difference[writes & same].max(initial=0.0)))
        flipped = max(flipped, float(difference[writes & ~same].max(initial=0.0)))
        flips += int((writes & ~same).sum())
    return Seen(error, flipped, flips, written, demands)


def apart(program: Program, got: Evaluated, some: list[Any], true: list[Any]) -> tuple[FloatArray, BoolArray]:
    """(N,) how far thrusts lie from those in real numbers [N], and whether both took the same branches.

    ``some`` and ``true`` are the program's values, rounded and not; ``got`` is its answer to the first.
    """
    off: FloatArray = np.abs(got.F - answered(program, true, len(got.F)).F).max(axis=1)
    return off, alike(program, some, true)
