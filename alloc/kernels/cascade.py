"""Redistribute's passes as a loop over data: which thrusts freeze decides what the others can still do."""

import re
from importlib import resources

import numpy as np

from alloc.allocation import FloatArray
from alloc.kernels.rules import Ruled
from alloc.kernels.template import filled, initialiser, unrolled
from alloc.kernels.tolerance import MET
from alloc.nullspace.structure import decompose
from alloc.program import Builder, DataLoop, Expression, Scalar
from alloc.program.literal import number
from alloc.program.sums import snapped
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.condition import magnified, wrench_doubt

RANK: dict[Scalar, float] = {"double": RANK_TOLERANCE, "float": 1e-5}
"""Length of a row below which it is rounding, relative to what it was before any froze [-]."""
DOUBT: dict[Scalar, float] = {"double": 1e-5, "float": 1e-2}
"""Most that rounding may take of the thrusts, relative to the largest limit [-]; more is refused."""
EACH = 8
"""Roundings of a Gram-Schmidt process for each thruster, as ``alloc.vehicle.condition`` counts them."""


def frozen(spare: float, builder: Builder, x: dict[int, Expression]) -> Ruled:
    """Thrusts beyond a limit by more than ``spare`` freeze there, the others share the rest of tau.

    ``spare`` is relative to the largest limit [-].
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
    # Other rules that nearly make tau leave T* tau by next to nothing, and their sums of what is missed do
    # not round. These thrusts leave it by whole limits. In float MET leaves that much already.
    hidden = min(wrench_doubt(vehicle), MET["double"] / 10) if builder.scalar == "double" else 0.0
    return Ruled({i: g[i] for i in x}, hidden=hidden, working=_working(builder, x))


def _working(builder: Builder, x: dict[int, Expression]) -> dict[int, Expression]:
    """Factors of the thrusts, 0 for a thruster that is off, so that the C shows its thrust to be zero.

    What the loop makes is an interval to an analyser. Limits of zero show it, where these are by fault.
    """
    if builder.limits.at_call or builder.limits.by_fault:
        return {}
    off = [i for i in x if i in builder.faults]
    return {i: builder.graph.by_fault(float(fault != i) for fault in builder.faults) for i in off}


def doubt(vehicle: Vehicle, scalar: Scalar) -> float:
    """Share of the largest limit by which rounding may move a thrust of the cascade in C [-].

    With H = L L' the effort is |L'f|^2. A thruster that freezes takes its part out of what the others can do,
    as a step of Gram-Schmidt does with rows, which loses a share EACH n u cond(A L'^-1) of L'f (Bjorck 1967);
    of f that is up to sqrt(cond H) times as much. Where others are frozen the weakest thruster may push
    alone: max |T_i| / min |T_i| times as much again.
    """
    on = vehicle.working
    L = np.linalg.cholesky(vehicle.H[np.ix_(on, on)])
    rows = np.linalg.solve(L, (vehicle.TP[:, on] / vehicle.row_lengths[:, None]).T)
    sigma = np.linalg.svd(rows, compute_uv=False)
    spread = float(sigma[0] / sigma[vehicle.rank - 1]) if vehicle.rank else 1.0
    unit = float(np.finfo(np.float32 if scalar == "float" else np.float64).eps)
    return EACH * len(on) * unit * spread * magnified(vehicle)


def _text(vehicle: Vehicle, scalar: Scalar, spare: float) -> str:
    """The C of the loop with this vehicle's numbers in it."""
    text = (resources.files("alloc.kernels") / "cascade.c").read_text(encoding="utf-8")
    full = np.count_nonzero(vehicle.H - np.diag(np.diag(vehicle.H)))
    text = re.sub(r"^( *)//full ?(.*\n)", r"\1\2" if full else "", text, flags=re.MULTILINE)
    Z, E = _responses(vehicle)
    text = unrolled(text, {"K": vehicle.k, "N": vehicle.n, "D": Z.shape[1]})
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
    return filled(text, words)


def _responses(vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    """(n, d) thrusts without a wrench, Z'HZ = I, and (n, k) those of a wrench in rows of unit length.

    Of a vehicle without a null space Z has one column of zeros.
    """
    structure = decompose(vehicle)
    columns = []
    for block in structure.blocks:
        part = np.zeros((vehicle.n, block.N.shape[1]))
        part[block.rows] = block.N
        columns.append(part)
    Z = np.hstack(columns or [np.zeros((vehicle.n, 1))])
    return Z, snapped(structure.G * vehicle.row_lengths)
