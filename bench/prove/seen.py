"""Many attainable demands answered by a program: how far rounding took them, and whether they were met."""

from typing import NamedTuple

import numpy as np

from alloc import FloatArray, Vehicle
from alloc.native.code import Scalar
from bench.prove.numeric import answers
from bench.prove.symbolic import Node, Program

CHUNK = 10_000
"""Demands at a time: so many values of every operation fit a processor's cache."""
CORNERS = 0.3
"""Share of the thrusts that make demands which stand at a limit: rounding is largest there."""
INSIDE = 0.999
"""Demands are made this much smaller than attainable, so that rounding decides no verdict."""
KINDS = {"double": (np.float64, np.longdouble), "float": (np.float32, np.float64)}
"""The scalar, and what the formula is calculated in beside it."""
MET: dict[Scalar, float] = {"double": 1e-6, "float": 1e-4}
"""|T f - tau| of a demand that counts as met, relative to ``wrench_scale`` [-]."""


class Seen(NamedTuple):
    """What was seen.

    Attributes
    ----------
    error : largest |f - f in real numbers| of all that were answered [N]
    missed : largest |T f - tau| of all that were SOLVED, relative to ``wrench_scale`` [-]
    answered, solved, demands : how many of them
    """

    error: float
    missed: float
    answered: int
    solved: int
    demands: int


def seen(
    program: Program,
    vehicle: Vehicle,
    scalar: Scalar,
    exact: dict[Node, float],
    demands: int,
    wider: bool = True,
) -> Seen:
    """Answer so many seeded attainable demands; without ``wider`` the error is left out, and is zero."""
    rng = np.random.default_rng(2004)
    narrow, wide = KINDS[scalar]
    error = missed = 0.0
    answered = solved = 0
    for begin in range(0, demands, CHUNK):
        count = min(CHUNK, demands - begin)
        tau = (INSIDE * (vehicle.TP @ _thrusts(vehicle, rng, count))).astype(narrow)
        got = answers(program, {"tau": tau}, narrow)
        writes, meets = (got.status == 0) | (got.status == 1), got.status == 0
        f = got.outputs["f"].astype(float)
        answered, solved = answered + int(writes.sum()), solved + int(meets.sum())
        miss = np.abs(vehicle.TP @ f - tau) / vehicle.wrench_scale[:, None]
        missed = max(missed, float(miss[:, meets].max(initial=0.0)))
        if wider:
            true = answers(program, {"tau": tau}, wide, exact).outputs["f"]
            difference = np.abs(got.outputs["f"] - true)
            error = max(error, float(difference[:, writes].max(initial=0.0)))
    return Seen(error, missed, answered, solved, demands)


def _thrusts(vehicle: Vehicle, rng: np.random.Generator, count: int) -> FloatArray:
    low, high = vehicle.f_min[:, None], vehicle.f_max[:, None]
    shape = (vehicle.n, count)
    ends = np.where(rng.random(shape) < 0.5, low, high)
    return np.where(rng.random(shape) < CORNERS, ends, rng.uniform(low, high, shape))
