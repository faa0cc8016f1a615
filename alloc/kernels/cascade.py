"""Passes of ``redistribute`` as a loop over data: frozen thrusts determine what the others can add."""

import re
from importlib import resources

import numpy as np

from alloc.allocation import FloatArray
from alloc.kernels.rules import RuleAnswer
from alloc.kernels.template import fill_words, initialiser, unroll
from alloc.kernels.tolerance import WRENCH_ERROR
from alloc.nullspace.structure import decompose
from alloc.program import Builder, DataLoop, Expression, Scalar
from alloc.program.literal import number
from alloc.program.sums import snapped
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.condition import magnified, wrench_doubt

RANK: dict[Scalar, float] = {"double": RANK_TOLERANCE, "float": 1e-5}
"""Length of a row that counts as zero, over its length before any thruster froze [-]."""
DOUBT: dict[Scalar, float] = {"double": 1e-5, "float": 1e-2}
"""Largest rounding of a thrust over the largest limit [-]; vehicles with more are refused."""
EACH = 8
"""Roundings of a Gram-Schmidt step, as ``alloc.vehicle.condition`` counts them."""


def freeze_thrusts(spare: float, builder: Builder, x: dict[int, Expression]) -> RuleAnswer:
    """Freeze thrusts that exceed a limit by more than ``spare``, and let the others make the rest of tau.

    ``spare`` is over the largest limit [-].
    """
    vehicle, n = builder.vehicle, builder.vehicle.n
    known = builder.faults or {-1: vehicle}
    ends = {i: builder.limits.ends(i) for i in x}
    low, high = ([ends[i][side] if i in ends else 0.0 for i in range(n)] for side in (0, 1))
    loop = DataLoop(
        name="cascade",
        text=_text(vehicle, builder.scalar, spare),
        arrays=(("low", n), ("high", n), ("g", n)),
        flags=tuple(tuple(int(i in ends and i != fault) for i in range(n)) for fault in known),
    )
    g = builder.loop(loop, low, high, [x.get(i, 0.0) for i in range(n)])
    # Other rules that nearly make tau stay near T* tau, so their error sums hardly round. These thrusts may
    # lie whole limits away from it. In float WRENCH_ERROR has room for that.
    hidden = min(wrench_doubt(vehicle), WRENCH_ERROR["double"] / 10) if builder.scalar == "double" else 0.0
    return RuleAnswer({i: g[i] for i in x}, hidden=hidden, working=_working(builder, x))


def _working(builder: Builder, x: dict[int, Expression]) -> dict[int, Expression]:
    """Factors of the thrusts, 0 for a failed thruster, which prove its thrust zero to an analyser.

    An analyser sees an interval behind the loop. Limits by fault prove it without factors.
    """
    if builder.limits.at_call or builder.limits.by_fault:
        return {}
    off = [i for i in x if i in builder.faults]
    return {i: builder.graph.by_fault(float(fault != i) for fault in builder.faults) for i in off}


def doubt(vehicle: Vehicle, scalar: Scalar) -> float:
    """Rounding of a thrust of the loop in C over the largest limit [-].

    With H = L L' the effort is |L'f|^2. Freezing a thruster is a step of Gram-Schmidt, relative error
    EACH n u cond(A L'^-1) of L'f (Bjorck 1967) and up to sqrt(cond H) times that of f. If only the weakest
    thruster is left, max |T_i| / min |T_i| times as much again.
    """
    on = vehicle.working
    L = np.linalg.cholesky(vehicle.H[np.ix_(on, on)])
    rows = np.linalg.solve(L, (vehicle.TP[:, on] / vehicle.row_lengths[:, None]).T)
    sigma = np.linalg.svd(rows, compute_uv=False)
    spread = float(sigma[0] / sigma[vehicle.rank - 1]) if vehicle.rank else 1.0
    unit = float(np.finfo(np.float32 if scalar == "float" else np.float64).eps)
    return EACH * len(on) * unit * spread * magnified(vehicle)


def _text(vehicle: Vehicle, scalar: Scalar, spare: float) -> str:
    """C text of the loop with this vehicle's numbers."""
    text = (resources.files("alloc.kernels") / "cascade.c").read_text(encoding="utf-8")
    full = np.count_nonzero(vehicle.H - np.diag(np.diag(vehicle.H)))
    text = re.sub(r"^( *)//full ?(.*\n)", r"\1\2" if full else "", text, flags=re.MULTILINE)
    Z, E = _responses(vehicle)
    text = unroll(text, {"K": vehicle.k, "N": vehicle.n, "D": Z.shape[1]})
    least = RANK[scalar] ** 2 * np.column_stack([(Z**2).sum(axis=1), (E**2).sum(axis=1)])
    words = {
        "SCALAR": scalar,
        "K": str(vehicle.k),
        "N": str(vehicle.n),
        "D": str(Z.shape[1]),
        "ZERO": number(0.0, scalar),
        "ONE": number(1.0, scalar),
        "SPARE": number(spare * vehicle.f_scale, scalar),
        "NULL_SPACE": initialiser(Z, scalar),
        "INVERSE": initialiser(E, scalar),
        "LEAST": initialiser(least, scalar),
        "HESSIAN": initialiser(vehicle.H, scalar),
        "MOVED": "y" if full else "f",
    }
    return fill_words(text, words)


def _responses(vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    """Null space Z (n, d) with Z'HZ = I, and inverse (n, k) for rows of T of unit length.

    Without a null space Z is one column of zeros.
    """
    structure = decompose(vehicle)
    columns = []
    for block in structure.blocks:
        part = np.zeros((vehicle.n, block.N.shape[1]))
        part[block.rows] = block.N
        columns.append(part)
    Z = np.hstack(columns or [np.zeros((vehicle.n, 1))])
    return Z, snapped(structure.G * vehicle.row_lengths)
