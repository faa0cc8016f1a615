"""Cases of a self-test: arguments, the answer of the twin in Python, and its change by rounding."""

from dataclasses import dataclass

import numpy as np

from alloc.allocation import Allocator, BoolArray, FloatArray, Status, StatusArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.kernels.held import at_rest
from alloc.kernels.tolerance import MET, TOLERANCE
from alloc.program import Scalar, Where
from alloc.reach.edge import start
from alloc.vehicle import Vehicle

AGREEMENT: dict[Scalar, float] = {"double": 1e-12, "float": 1e-5}
"""|f - expected| that every case may have, relative to the largest limit: rounding of a few dozen terms."""
ROUNDING: dict[Scalar, float] = {"double": 2.5e-14, "float": 1e-6}
"""What a kernel's sums may lose, relative to the largest term [-]: in float a few dozen roundings; in double
more than those the matrix, whose entries count as equal within 1.4e-14 and as zero below 1e-14 of the largest
(``alloc.program.sums.snapped``)."""
TRIES = 8
"""Times that all arguments of a case are moved by what rounding takes, to see what becomes of the answer."""
JUMP = 0.01
"""Largest difference of a thrust that may be right, relative to the largest limit, whatever explains it [-]:
where rounding may do more to the answer it is not asked for."""
MISSED: dict[Scalar, float] = {"double": 1e-6, "float": 1e-4}
"""Largest difference of a wrench that may be right, relative to ``wrench_scale`` [-]; always asked for."""
PER_FAULT = 24
"""Cases for the whole vehicle, and for each fault."""


@dataclass(frozen=True, eq=False)
class Cases:
    """N calls and their answers.

    Attributes
    ----------
    taus : (N, k) wrenches [N, N m]
    f_min, f_max : (N, n) limits of each call [N]
    F : (N, n) thrusts that the twin gives [N]; NaN where f stays as it was
    status : (N,) what it says
    other : (N,) what a kernel may say in its place: where rounding may move the thrusts by more than a SOLVED
        wrench may miss, SOLVED and PARTIAL are both right; else the status itself
    share : (N, levels) what of each level is delivered [-]; no columns where the method has no levels
    allowed : (N,) largest difference of a thrust that rounding explains [N]
    allowed_share : (N,) that of a share [-]
    undecided : (N,) whether rounding decides what the answer is: what is SOLVED must make tau all the same
    """

    taus: FloatArray
    f_min: FloatArray
    f_max: FloatArray
    F: FloatArray
    status: StatusArray
    other: StatusArray
    share: FloatArray
    allowed: FloatArray
    allowed_share: FloatArray
    undecided: BoolArray


def cases(
    vehicle: Vehicle, twin: Allocator, scalar: Scalar, limits: Where, levels: int, doubt: float = 0.0
) -> Cases:
    """Seeded calls for one vehicle with its faults, of a method with so many levels.

    A kernel rounds its arguments, and sums of products |T*| |tau|: what that takes of a thrust is ROUNDING of
    ``size``, or ``doubt`` where a kernel loses more. So the thrusts that make demands are moved by so much,
    and the limits, all by random signs. With sigma the root mean square of what this does to an answer, the
    worst of signs of p = 3 n arguments does at most sqrt(p) sigma, by Cauchy and Schwarz. Two more moves:
    float takes thrusts farther beyond limits as inside than the twin does, so limits are wider by that much;
    and the end of a way is rounded too, which may cost a weak thruster more than all arguments do, so the
    demand is what its answer pushes, a little back on the way. A case whose status changes, or whose answer
    jumps, is undecided.
    """
    rng = np.random.default_rng(1999)
    low, high = _limits(vehicle, limits, rng)
    f = _thrusts(vehicle, low, np.maximum(low, high), rng)
    terms = np.abs(generalized_inverse(vehicle)) @ np.abs(vehicle.TP @ f.T)
    size = np.maximum(terms.max(axis=0), vehicle.f_scale)[:, None]

    def answers(
        f: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, StatusArray, FloatArray]:
        taus = f @ vehicle.TP.T
        each = (twin(*one) for one in zip(taus, low, high, strict=True)) if levels else ()
        shares = np.array([one.share for one in each]).reshape(len(taus), levels)
        return *twin.many(taus, low, high), shares

    F, status, share = answers(f, low, high)
    squares, squares_share = np.zeros(PER_FAULT), np.zeros(PER_FAULT)
    same = np.ones(PER_FAULT, dtype=bool)
    apart = (low != high) * vehicle.f_scale  # zero width stays zero width

    def moved(f: FloatArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        others, verdict, shares = answers(f, low, high)
        same[verdict != status] = False
        far = far_off(others, F)
        same[far > JUMP * vehicle.f_scale] = False
        return far, np.abs(shares - share).max(axis=1, initial=0.0)

    lost = max(ROUNDING[scalar], doubt)
    for _ in range(TRIES):
        by = lost * rng.choice([-1.0, 1.0], (3, *f.shape))
        far, far_share = moved(f + by[0] * size, low + by[1] * apart, high + by[2] * apart)
        squares, squares_share = squares + far**2 / TRIES, squares_share + far_share**2 / TRIES
    slack = (TOLERANCE[scalar] - TOLERANCE["double"]) * apart
    wider, wider_share = moved(f, low - slack, high + slack)
    if levels:
        short = F - lost * (F - start(low, np.maximum(low, high)))
        back = far_off(answers(np.nan_to_num(short), low, high)[0], F)
        wider += back
        # A kernel reduces thrusts that end beyond limits, and their shares (``alloc.kernels.held``).
        rest = at_rest(vehicle) if limits == "fixed" else start(low, np.maximum(low, high))
        room = np.where(low < high, np.minimum(high - rest, rest - low), np.inf)
        room = room[:, vehicle.working].min(axis=1)
        wider_share += JUMP * back / np.maximum(np.maximum(JUMP * room, back), 1e-300)
    worst, agreed = np.sqrt(3.0 * vehicle.n), max(AGREEMENT[scalar], doubt)
    allowed = agreed * size[:, 0] + worst * np.sqrt(squares) + wider
    if doubt:  # where a demand is met in part, errors in a matrix are magnified twice (Wedin 1973)
        allowed += squares / (lost * size[:, 0])
    same[allowed > JUMP * vehicle.f_scale] = False
    allowed_share = agreed + worst * np.sqrt(squares_share) + wider_share
    other = status if levels else _either(vehicle, f @ vehicle.TP.T, F, status, allowed, scalar)
    return Cases(
        taus=f @ vehicle.TP.T,
        f_min=low,
        f_max=high,
        F=F,
        status=status,
        other=other,
        share=share,
        allowed=allowed,
        allowed_share=allowed_share,
        undecided=~same,
    )


def far_off(F: FloatArray, from_: FloatArray) -> FloatArray:
    """(N,) largest difference of a thrust [N]; zero where there is none to compare."""
    largest: FloatArray = np.nan_to_num(np.abs(F - from_)).max(axis=1)
    return largest


def _either(
    vehicle: Vehicle,
    taus: FloatArray,
    F: FloatArray,
    status: StatusArray,
    allowed: FloatArray,
    scalar: Scalar,
) -> StatusArray:
    """The other one of SOLVED and PARTIAL where thrusts ``allowed`` apart may decide between them.

    The twin draws the line at MET of double, a kernel at that of its scalar; between them both are right.
    """
    unit = 1.0 / vehicle.wrench_scale
    missed = np.abs((F @ vehicle.TP.T - taus) * unit).max(axis=1)
    moved = allowed * (np.abs(vehicle.TP) * unit[:, None]).sum(axis=1).max()
    near = (missed >= MET["double"] - moved) & (missed <= MET[scalar] + moved)
    decided = np.isin(status, (Status.SOLVED, Status.PARTIAL)) & near
    other: StatusArray = np.where(decided, Status.SOLVED + Status.PARTIAL - status, status).astype(np.int8)
    return other


def _limits(vehicle: Vehicle, limits: Where, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """(PER_FAULT, n) limits: the vehicle's, narrower ones, of zero width, that exclude zero, that cross."""
    shape = (PER_FAULT, vehicle.n)
    low, high = (np.broadcast_to(side, shape).copy() for side in (vehicle.f_min, vehicle.f_max))
    if limits == "fixed":
        return low, high
    ends = np.sort(rng.uniform(low, high, (2, *shape)), axis=0)
    narrow = np.arange(PER_FAULT) % 3 > 0
    low[narrow], high[narrow] = ends[0, narrow], ends[1, narrow]
    closed = np.arange(PER_FAULT) % 6 == 4
    one = rng.integers(vehicle.n, size=PER_FAULT)
    high[closed, one[closed]] = low[closed, one[closed]]
    crossing = np.arange(PER_FAULT) % 12 == 11
    low[crossing, one[crossing]] = high[crossing, one[crossing]] + 0.01 * vehicle.f_scale
    return low, high


def _thrusts(vehicle: Vehicle, low: FloatArray, high: FloatArray, rng: np.random.Generator) -> FloatArray:
    """(PER_FAULT, n) thrusts to make wrenches of: zero, inside the limits, near them, and beyond."""
    f = rng.uniform(low, high)
    f[1::4] *= 3.0
    corners = np.where(rng.random(f[2::4].shape) < 0.5, low[2::4], high[2::4])
    middle = 0.5 * (low[2::4] + high[2::4])
    f[2::4] = middle + 0.999 * (corners - middle)
    f[0] = 0.0
    return f
