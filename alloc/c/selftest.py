"""A C program that checks a generated kernel against answers computed in Python."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from alloc.allocation import Allocator, BoolArray, FloatArray, Status, StatusArray
from alloc.c.target import NOT_FINITE, Target
from alloc.c.text import IN_C, listed, static, table
from alloc.closed_forms.inverse import generalized_inverse
from alloc.kernels.correction import rest_thrusts
from alloc.kernels.tolerance import TOLERANCE, WRENCH_ERROR
from alloc.program import Scalar, Where
from alloc.program.literal import number
from alloc.reach.edge import start
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import Azimuth

UNTOUCHED = 12345.0
"""Fill of f before a call; a kernel that finds no thrust must leave it there."""
AGREEMENT: dict[Scalar, float] = {"double": 1e-12, "float": 1e-5}
"""|f - expected| that every case may have, relative to the largest limit: rounding of a few dozen terms."""
ROUNDING: dict[Scalar, float] = {"double": 2.5e-14, "float": 1e-6}
"""Loss of a kernel's sums, relative to the largest term [-]: in float a few dozen roundings; in double
more than those the matrix, whose entries count as equal within 1.4e-14 and as zero below 1e-14 of the largest
(``alloc.program.sums.snapped``)."""
TRIES = 8
"""Times that all arguments of a case are moved by what rounding takes, to see what becomes of the answer."""
JUMP = 0.01
"""Largest difference of a thrust that may be right, relative to the largest limit, whatever explains it [-]:
where rounding may do more to the answer it is not asked for."""
MISSED: dict[Scalar, float] = {"double": 1e-6, "float": 1e-4}
"""Largest difference of a wrench that may be right, relative to ``wrench_scale`` [-]; always asked for."""
SIDES: dict[Scalar, float] = {"double": 4e-15, "float": 2e-6}
"""Distance beyond a side that sums in the scalar may show, relative to the largest limit [-]."""
INSIDE = """\
static int inside(int status, const {scalar} *f)
{{
    for (int i = 0; (status == TB_SOLVED || status == TB_PARTIAL) && i < {count}; i++) {{
        {scalar} along = 0;
        for (int j = 0; j < {n}; j++) {{
            along += sides[i][j] * f[j];
        }}
        status = along <= reach[i] ? status : 99;
    }}
    return status;
}}
"""
"""A call's status; 99, which no call has, where thrusts lie outside of a polygon."""
PER_FAULT = 24
"""Cases for the whole vehicle, and for each fault."""


def selftest(target: Target, digest: str) -> str:
    """C program that compares a target's function with the answers of its method in Python.

    Thrusts may differ by JUMP, wrenches by MISSED. SOLVED answers must always reproduce tau, also where
    rounding decides the answer. At the end of a way, which rounding moves, thrusts may
    differ that make the same wrench inside the limits with no more effort. The program exits with 0 where
    all answers agree, else with 1; it prints the largest error, and the ``digest`` of header and source.
    """
    vehicle, scalar, levels = target.vehicle, target.scalar, target.levels
    known = (-1, *target.failures.tolist())
    rows = [row for fault in known for row in _rows(target, fault)]
    each = {fault: target.method.subject(target.with_fault(fault)) for fault in known}
    differ = any(subject.units is not None for subject in each.values())  # each leaves other directions out
    at_call = target.limits == "call"
    ends = f"    {scalar} f_min[{vehicle.n}];\n    {scalar} f_max[{vehicle.n}];\n" * at_call
    shares = f"    {scalar} allowed_share;\n    {scalar} share[{levels}];\n" * (levels > 0)
    call = target.arguments("(one).fault").replace("f_m", "(one).f_m").replace("tau", "(one).tau")
    macros = {
        "NAME": f'"{target.name}"',
        "DIGEST": f'"{digest}"',
        "N": str(vehicle.n),
        "K": str(vehicle.k),
        "LEVELS": str(levels),
        "CALL(one)": f"(T = of_each[(one).fault + 1], {target.name}({call}))"
        if differ
        else f"inside({target.name}({call}), f)"
        if vehicle.azimuths
        else f"{target.name}({call})",
        "LIMITS(one)": "(one).f_min, (one).f_max" if at_call else "low, high",
        "UNTOUCHED": number(UNTOUCHED, scalar),
        "JUMP": number(JUMP * vehicle.f_scale, scalar),
        "SAME_WRENCH": number(WRENCH_ERROR[scalar] / MISSED[scalar], scalar),
        "SAME_EFFORT": number(1.0 + WRENCH_ERROR[scalar] / 10, scalar),
    }
    tables = [table("T", vehicle.TP, scalar)]
    if differ:
        of_each = np.array([each.get(fault, vehicle).TP for fault in range(-1, vehicle.n)])
        tables = [table("of_each", of_each, scalar), f"static const {scalar} (*T)[N];"]
    tables += [table("most", MISSED[scalar] * vehicle.wrench_scale, scalar)]
    if planes := vehicle.half_planes:
        reach = planes.reach + SIDES[scalar] * vehicle.f_scale
        tables += [table("sides", planes.A, scalar), table("reach", reach, scalar)]
        tables += [INSIDE.format(count=len(reach), n=vehicle.n, scalar=scalar)]
    if levels:
        tables += [table("H", vehicle.H, scalar)]
        sides = {} if at_call else {"low": vehicle.f_min, "high": vehicle.f_max}
        tables += [table(side, values, scalar) for side, values in sides.items()]
    return f"""\
{IN_C}
/* Generated by thrustbench: calls {target.name} and compares with answers computed beforehand.
 * newlib-nano prints numbers only where it is linked with -u _printf_float. */
#include <math.h>
#include <stdio.h>

#include "{target.name}.h"

{chr(10).join(f"#define {macro} {text}" for macro, text in macros.items())}

static const struct {{
    int fault;
    int status;
    int other; /* status that rounding may make of it */
    int undecided; /* 1 where rounding decides what the answer is */
    {scalar} allowed;
    {scalar} tau[{vehicle.k}];
{ends}    {scalar} f[{vehicle.n}];
{shares}}} cases[] = {{
{chr(10).join(rows)}
}};

{chr(10).join(tables)}

{static("selftest.c", scalar)}"""


def _rows(target: Target, fault: int) -> Iterator[str]:
    """The initialisers of all cases of one fault."""
    allocator = target.method.build(target.with_fault(fault))
    vehicle = target.method.subject(target.with_fault(fault))
    scalar, limits, levels = target.scalar, target.limits, target.levels
    asked = cases(target, vehicle, allocator)
    # NaN shows a kernel that reads the limits of a thruster that is off.
    off = vehicle.readiness == 0
    low, high = (np.where(off, np.nan, side) for side in (asked.f_min, asked.f_max))

    def row(
        status: int, other: int, undecided: bool, allowed: list[float], tau: FloatArray, *arrays: FloatArray
    ) -> str:
        f_min, f_max, f, share = arrays
        answered = [np.where(np.isfinite(each), each, UNTOUCHED) for each in (f, share)]
        if status not in (Status.SOLVED, Status.PARTIAL):
            answered[1] = np.full(levels, UNTOUCHED)
        ends = [f_min, f_max] if limits == "call" else []
        parts = [f"{fault}, {status}, {other}, {int(undecided)}, {number(allowed[0], scalar)}"]
        parts += [listed(each, scalar) for each in (tau, *ends, answered[0])]
        parts += [number(allowed[1], scalar), listed(answered[1], scalar)] if levels else []
        return f"    {{{', '.join(parts)}}},"

    for i, status in enumerate(asked.status.tolist()):
        allowed = [float(asked.allowed[i]), float(asked.allowed_share[i])]
        other = int(asked.other[i])
        unsure = bool(asked.undecided[i])
        yield row(status, other, unsure, allowed, asked.taus[i], low[i], high[i], asked.F[i], asked.share[i])
    if not allocator.limited:
        return
    nothing = np.full(vehicle.n, np.nan), np.full(levels, np.nan)
    for odd in (np.nan, np.inf, -np.inf):
        for given in (0, 1, 2) if limits == "call" else (0,):
            tau = np.zeros(vehicle.k)
            f_min, f_max = (np.where(off, np.nan, side) for side in (vehicle.f_min, vehicle.f_max))
            (tau, f_min, f_max)[given][0 if given == 0 else vehicle.working[-1]] = odd
            yield row(NOT_FINITE, NOT_FINITE, False, [0.0, 0.0], tau, f_min, f_max, *nothing)


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


def cases(target: Target, vehicle: Vehicle, twin: Allocator) -> Cases:
    """Seeded calls for a target's vehicle with its faults, and the answers of the method in Python.

    A kernel rounds its arguments, and sums of products |T*| |tau|: what that takes of a thrust is ROUNDING of
    ``size``, or the recipe's ``doubt`` where a kernel loses more. So the thrusts that make demands are moved
    by so much, and the limits, all by random signs. With sigma the root mean square of what this does to an
    answer, the worst of signs of p = 3 n arguments does at most sqrt(p) sigma, by Cauchy and Schwarz. Two
    more moves: float takes thrusts farther beyond limits as inside than the twin does, so limits are wider by
    that much; and the end of a way is rounded too, which may cost a weak thruster more than all arguments do,
    so the demand is what its answer pushes, a little back on the way. A case whose status changes, or whose
    answer jumps, is undecided.
    """
    scalar, limits, levels = target.scalar, target.limits, target.levels
    doubt = target.method.doubt(vehicle, scalar)
    rng = np.random.default_rng(1999)
    low, high = _limits(vehicle, limits, rng)
    f = _thrusts(low, np.maximum(low, high), rng, vehicle.turning)
    terms = np.abs(generalized_inverse(vehicle)) @ np.abs(vehicle.TP @ f.T)
    size = np.maximum(terms.max(axis=0), vehicle.f_scale)[:, None]

    def answers(
        f: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, StatusArray, FloatArray]:
        taus = f @ vehicle.TP.T
        if vehicle.azimuths:
            return *twin.many(taus), np.array([twin(tau).share for tau in taus])
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
        far = largest_differences(others, F)
        same[far > JUMP * vehicle.f_scale] = False
        return far, np.abs(shares - share).max(axis=1, initial=0.0)

    lost = max(ROUNDING[scalar], doubt)
    for _ in range(TRIES):
        by = lost * rng.choice([-1.0, 1.0], (3, *f.shape))
        far, far_share = moved(f + by[0] * size, low + by[1] * apart, high + by[2] * apart)
        squares, squares_share = squares + far**2 / TRIES, squares_share + far_share**2 / TRIES
    slack = (TOLERANCE[scalar] - TOLERANCE["double"]) * apart
    wider, wider_share = moved(f, low - slack, high + slack)
    for scaled in (1.0 - TOLERANCE[scalar], 1.0 + SIDES[scalar]) if vehicle.azimuths else ():
        # A demand that is smaller stands for sets that are wider, and the other way round.
        far, far_share = moved(scaled * f, low, high)
        wider, wider_share = np.maximum(wider, far), np.maximum(wider_share, far_share)
    if levels:
        short = F - lost * (F - start(low, np.maximum(low, high)))
        back = largest_differences(answers(np.nan_to_num(short), low, high)[0], F)
        wider += back
        # A kernel reduces thrusts that end beyond limits, and their shares (``alloc.kernels.correction``).
        rest = rest_thrusts(vehicle) if limits == "fixed" else start(low, np.maximum(low, high))
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


def largest_differences(F: FloatArray, from_: FloatArray) -> FloatArray:
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

    The twin draws the line at WRENCH_ERROR of double, a kernel at that of its scalar; both are right between
    them.
    """
    unit = 1.0 / vehicle.wrench_scale
    missed = np.abs((F @ vehicle.TP.T - taus) * unit).max(axis=1)
    moved = allowed * (np.abs(vehicle.TP) * unit[:, None]).sum(axis=1).max()
    near = (missed >= WRENCH_ERROR["double"] - moved) & (missed <= WRENCH_ERROR[scalar] + moved)
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


def _thrusts(
    low: FloatArray, high: FloatArray, rng: np.random.Generator, turning: Sequence[Azimuth]
) -> FloatArray:
    """(PER_FAULT, n) thrusts to make wrenches of: zero, inside the limits, near them, and beyond."""
    f = rng.uniform(low, high)
    corners = np.where(rng.random(f[2::4].shape) < 0.5, low[2::4], high[2::4])
    for azimuth in turning:
        own = azimuth.corners
        f[:, azimuth.components] = rng.dirichlet(np.ones(len(own)), PER_FAULT) @ own
        corners[:, azimuth.components] = own[rng.integers(len(own), size=len(corners))]
    f[1::4] *= 3.0
    middle = 0.5 * (low[2::4] + high[2::4])
    for azimuth in turning:
        middle[:, azimuth.components] = azimuth.middle
    f[2::4] = middle + 0.999 * (corners - middle)
    f[0] = 0.0
    return f
