"""Redistribute's passes as a loop over data: which thrusts freeze decides what is factorised next."""

import re
from importlib import resources

import numpy as np

from alloc.allocation import FloatArray
from alloc.program import Builder, DataLoop, Expression, Scalar
from alloc.program.literal import number
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.condition import magnified

RANK: dict[Scalar, float] = {"double": RANK_TOLERANCE, "float": 1e-5}
"""Length of a row below which it is rounding, relative to the longest [-]."""
DOUBT: dict[Scalar, float] = {"double": 1e-5, "float": 1e-2}
"""What rounding may take of the thrusts, relative to the largest limit [-]; more is refused."""
EACH = 8
"""Roundings of a Gram-Schmidt process for each thruster, as ``alloc.vehicle.condition`` counts them."""


def frozen(spare: float, builder: Builder, x: dict[int, Expression]) -> dict[int, Expression]:
    """Thrusts beyond a limit by more than ``spare`` freeze there, the others share the rest of tau.

    ``spare`` is relative to the largest limit [-].
    """
    vehicle, n = builder.vehicle, builder.vehicle.n
    ends = {i: builder.limits.ends(i) for i in x}
    low, high = ([ends[i][side] if i in ends else 0.0 for i in range(n)] for side in (0, 1))
    loop = DataLoop(
        name="cascade",
        text=_text(vehicle, builder.scalar, spare),
        arrays=(("tau", vehicle.k), ("low", n), ("high", n), ("g", n)),
        flags=tuple(int(i in ends) for i in range(n)),
    )
    g = builder.loop(loop, builder.tau, low, high, [x.get(i, 0.0) for i in range(n)])
    return {i: g[i] for i in x}


def doubt(vehicle: Vehicle, scalar: Scalar) -> float:
    """Share of the largest limit by which rounding may move a thrust of the cascade in C [-].

    With H = L L' the effort is |L'f|^2, and orthogonal rows of A L'^-1 are found by Gram-Schmidt, which loses
    a share EACH n u cond(A L'^-1) of L'f (Bjorck 1967); of f that is up to sqrt(cond H) times as much. Where
    others are frozen the weakest thruster may push alone: max |T_i| / min |T_i| times as much again.
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
    words = {
        "SCALAR": scalar,
        "K": str(vehicle.k),
        "N": str(vehicle.n),
        "ZERO": number(0.0, scalar),
        "ONE": number(1.0, scalar),
        "SPARE": number(spare * vehicle.f_scale, scalar),
        "RANK": number(RANK[scalar] ** 2, scalar),
        "TP": _rows(vehicle.TP / vehicle.row_lengths[:, None], scalar),
        "HESSIAN": _rows(vehicle.H, scalar),
        "UNITS": _rows(1.0 / vehicle.row_lengths[None, :], scalar)[1:-1],
    }
    return re.sub(rf"\b({'|'.join(words)})\b", lambda word: words[word[0]], text)


def _rows(matrix: FloatArray, scalar: Scalar) -> str:
    rows = (", ".join(number(value, scalar) for value in row) for row in matrix.tolist())
    return "{" + ", ".join(f"{{{row}}}" for row in rows) + "}"
