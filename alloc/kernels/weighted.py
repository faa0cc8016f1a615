"""Weighted least squares within limits as a loop over data: an active set with tabulated products."""

from functools import lru_cache
from importlib import resources

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.closed_forms.weighted import STEPS_PER_THRUSTER, aims, rounded
from alloc.errors import NotApplicable
from alloc.kernels.entry import TAU, SeenArguments, all_thrusters, clamp_thrusts, refuse
from alloc.kernels.rules import makes_tau
from alloc.kernels.template import fill_words, initialiser, unroll
from alloc.kernels.tolerance import DOUBLE, SINGLE
from alloc.program import Builder, DataLoop, Program, Scalar, States, Where, select
from alloc.program.literal import number
from alloc.vehicle import Vehicle

MOST_THRUSTERS = 8
"""Most thrusters of a table: 1,024 rows, 28 kB of floats for six axes. Each further one doubles that."""
UNIT: dict[Scalar, float] = {"double": 2 * DOUBLE, "float": 2 * SINGLE}
"""Distance of neighbouring numbers over these [-]."""


def weighted(vehicle: Vehicle, limits: Where, scalar: Scalar, faults: States | None = None) -> Program:
    """Program of the soft optimum; raises NotApplicable for too many thrusters or a full H.

    A failed thruster is never free, so one table serves all ``faults``.
    """
    if vehicle.n > MOST_THRUSTERS:
        raise NotApplicable(
            f"{vehicle.name}: soft as C holds a row for each set of free thrusters, for {MOST_THRUSTERS}"
            f" thrusters at most, and there are {vehicle.n}; take scaled, or soft in Python"
        )
    builder, n = Builder(vehicle, limits, scalar, faults), vehicle.n
    working = vehicle.working.tolist()
    seen = SeenArguments([(TAU, j) for j in range(vehicle.k)], builder)
    seen.add(working, "0")
    refuse(builder, seen, [], exact=False)
    ends = {i: builder.limits.ends(i) for i in working}
    low, high = ([ends[i][side] if i in ends else 0.0 for i in range(n)] for side in (0, 1))
    loop = DataLoop(
        name="weighted",
        text=_text(vehicle, scalar),
        arrays=(("tau", vehicle.k), ("low", n), ("high", n), ("g", n + 1)),
        flags=tuple(
            tuple(int(i in ends and i != fault) for i in range(n)) for fault in faults or {-1: vehicle}
        ),
    )
    *g, unsolved = builder.loop(loop, builder.tau, low, high, [0.0] * (n + 1))
    builder.refuse(unsolved > 0.0, Status.NOT_CONVERGED)
    y = clamp_thrusts(builder, {i: g[i] for i in working}, builder.limits)
    met = makes_tau(builder, y)
    builder.compute(met)
    return builder.program(all_thrusters(builder, y), select(met, Status.SOLVED, Status.PARTIAL))


def doubt(vehicle: Vehicle, scalar: Scalar) -> float:
    """Relative rounding of a thrust [-]."""
    return rounded(vehicle, _rows(vehicle), UNIT[scalar])


@lru_cache(maxsize=16)
def _rows(vehicle: Vehicle) -> FloatArray:
    """Rows (n, sets without the thruster, k) of the table, by thruster."""
    n = vehicle.n
    rows = aims(vehicle, np.arange(1 << n))
    without = [[free for free in range(1 << n) if not free >> i & 1] for i in range(n)]
    return np.array([rows[sets, i] for i, sets in enumerate(without)])


def _text(vehicle: Vehicle, scalar: Scalar) -> str:
    """C text of the loop with this vehicle's numbers."""
    text = (resources.files("alloc.kernels") / "weighted.c").read_text(encoding="utf-8")
    rows = _rows(vehicle)
    own = np.einsum("isk,ki->is", rows, vehicle.TP)
    table = np.concatenate([rows, own[..., None]], axis=2)
    words = {
        "SCALAR": scalar,
        "K": str(vehicle.k),
        "N": str(vehicle.n),
        "SETS": str(rows.shape[1]),
        "COLUMNS": str(table.shape[2]),
        "TURNS": str(STEPS_PER_THRUSTER),
        "ZERO": number(0.0, scalar),
        "ONE": number(1.0, scalar),
        "ROUNDED": number(doubt(vehicle, scalar), scalar),
        "F_SCALE": number(vehicle.f_scale, scalar),
        "PER_AXIS": initialiser(1.0 / vehicle.wrench_scale, scalar),
        "COLUMNS_OF_T": initialiser(vehicle.TP.T, scalar),
        "AIMS": initialiser(table, scalar),
    }
    return fill_words(unroll(text, {"K": vehicle.k, "N": vehicle.n}), words)
