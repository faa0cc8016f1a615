"""Many demands answered by the compiled C itself, in this process."""

import ctypes
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alloc import Vehicle
from alloc.allocation import BoolArray, FloatArray, StatusArray
from alloc.c import arguments
from alloc.c.compiled import shared_library
from bench.demands import build_demands, labelled
from bench.demands.corners import attainable
from bench.judging.question import Question
from bench.proof.subject import Subject

DEMANDS, SEED = 2_000, 2004
"""Of each fault."""
MOVING = "jolts"
"""Demands with limits of their own, thrusters that are stuck and limits that cross among them: every other
one where the C takes limits of the call."""
SIZES = (0.1, 0.5, 0.9, 0.99, 1.0, 1 + 1e-7, 1 + 1e-5, 1.0003, 1.0009, 1.01, 2.0)
"""Demands are as many times as large as those of thrusts within the limits, many of which lie on the edge."""


PROCESSORS = (
    "#undef __ARM_FP\n",
    "#undef __ARM_FP\n#define __ARM_FP 12\n"
    "#undef __ARM_FEATURE_NUMERIC_MAXMIN\n#define __ARM_FEATURE_NUMERIC_MAXMIN 1\n",
)
"""What stands before the C to compile it as for an FPU without an instruction for a minimum, and with one."""


class FaultAnswers(NamedTuple):
    """Answers of the C to N demands of one fault.

    Attributes
    ----------
    vehicle : with that fault
    question : the demands, labelled
    F, status, share : (N, n) thrusts [N], zero where there are none, (N,) statuses and (N, levels) shares
    differ : (N,) which are answered otherwise where the FPU has an instruction for a minimum
    """

    vehicle: Vehicle
    question: Question
    F: FloatArray
    status: StatusArray
    share: FloatArray
    differ: BoolArray


def asked(of: Subject, fault: int) -> FaultAnswers:
    """Answers of the C to seeded demands of a fault; raises NotInstalled without a compiler."""
    vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
    rng = np.random.default_rng(SEED)
    scalar = np.float32 if of.scalar == "float" else np.float64
    wanted = (attainable(vehicle, rng, DEMANDS) * rng.choice(SIZES, DEMANDS)).T
    limits: list[FloatArray] = []
    if of.limits == "call":
        limits = [np.tile(side, (DEMANDS, 1)) for side in (vehicle.f_min, vehicle.f_max)]
        moved = build_demands(MOVING, vehicle, SEED, DEMANDS // 2)
        for whole, part in zip((wanted, *limits), (moved.taus, *moved.limits), strict=True):
            whole[::2] = part
        limits = [side.astype(scalar) for side in limits]
    # Demands are labelled before they are rounded: that may leave what thrusters span.
    demands = labelled(
        "proof", vehicle, np.ascontiguousarray(wanted), *(side.astype(float) for side in limits)
    )
    taus = np.ascontiguousarray(wanted.astype(scalar))
    given, other = (_run(of, fault, [taus, *limits], before) for before in PROCESSORS)
    differ = (np.hstack(given) != np.hstack(other)).any(axis=1)
    F, share, status = given
    return FaultAnswers(
        vehicle, Question(demands, {}, {}), F.astype(float), status[:, 0], share.astype(float), differ
    )


def _run(
    of: Subject, fault: int, arrays: Sequence[FloatArray], before: str
) -> tuple[FloatArray, FloatArray, StatusArray]:
    """Thrusts (N, n), shares (N, levels) and statuses (N, 1) of the C with some text before it.

    ``arrays`` are demands (N, k), and their limits (N, n) where the C takes these.
    """
    count, n, levels, scalar = len(arrays[0]), of.vehicle.n, of.levels, arrays[0].dtype
    F, share = np.zeros((count, n), scalar), np.zeros((count, max(levels, 1)), scalar)
    status = np.zeros((count, 1), np.intc)
    source, name = f"{of.name}.c", f"{of.name}_many"
    files = {**of.files, source: before + of.files[source], f"{name}.c": _many(of, name)}
    library = ctypes.CDLL(str(shared_library("proof", files)))
    filled: list[NDArray[Any]] = [F, *([share] if levels else []), status]
    given = [array.ctypes for array in (*arrays, *filled)]
    library[name](count, fault, *given)
    return F, share[:, :levels], status.astype(np.int8)


def _many(of: Subject, name: str) -> str:
    """C that answers many demands of one fault, one after the other."""
    n, k, levels, real = of.vehicle.n, of.vehicle.k, of.levels, of.scalar
    ends = f"const {real} *f_min, const {real} *f_max, " if of.limits == "call" else ""
    share = f"{real} *share, " if levels else ""
    further = f"tau += {k}, f += {n}" + (f", share += {levels}" if levels else "")
    further += f", f_min += {n}, f_max += {n}" if of.limits == "call" else ""
    return f"""\
#include "{of.name}.h"

void {name}(int count, int fault, const {real} *tau, {ends}{real} *f, {share}int *status)
{{
    for (int i = 0; i < count; i++, {further}) {{
        status[i] = {of.name}({arguments(of.limits, levels, "fault")});
    }}
}}
"""
