"""C99 of the practical rules: T* tau, mended where it lies beyond limits, and whether it makes tau still."""

import re
from importlib import resources

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.redistribute import BEYOND
from alloc.closed_forms.shrink import LEAST
from alloc.errors import NotApplicable
from alloc.native.bounds import CLimits
from alloc.native.code import (
    MET,
    TOLERANCE,
    Scalar,
    Table,
    Value,
    butterflies,
    defined,
    fold,
    number,
    placed,
    product,
    signed_sum,
)
from alloc.native.entry import SeenArguments, closed_form, cover, crossed, inside, read, refused, written
from alloc.native.rooms import taken
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.condition import magnified

SPARE: dict[Scalar, float] = {"double": BEYOND, "float": TOLERANCE["float"]}
"""Excess beyond which redistribute freezes a thrust, relative to the largest limit [-]; float rounds more."""
RANK: dict[Scalar, float] = {"double": RANK_TOLERANCE, "float": 1e-5}
"""Length of a row below which it is rounding, relative to the longest [-]."""

DOUBT: dict[Scalar, float] = {"double": 1e-5, "float": 1e-2}
"""What rounding may take of redistribute's thrusts, relative to the largest limit [-]; more is refused."""
EACH = 8
"""Roundings of a Gram-Schmidt process for each thruster, as ``alloc.vehicle.condition`` counts them."""


def clip(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
    """Statements of f = T* tau, each thrust cut at its limit."""
    return _mended(vehicle, [], {i: f"x{i}" for i in vehicle.working.tolist()}, bounds, c)


def shrink(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
    """Statements of f = s T* tau with the largest s in 0 … 1 that brings every excess to its limit."""
    working, one = vehicle.working.tolist(), number(1.0, c.scalar)
    far = {i: bounds.far(i, LEAST * vehicle.f_scale) for i in working}
    load = fold("most", [*(_load(f"x{i}", *far[i], c) for i in working), one])
    share = defined("share", f"{one} / {load}", c)
    return _mended(vehicle, [share], {i: f"share * x{i}" for i in working}, bounds, c)


def _load(x: str, low: Value, high: Value, c: Table) -> str:
    """C of x over the limit on its side of zero, of which neither is zero."""
    if isinstance(low, float) and isinstance(high, float):
        return taken(x, high, -low, c)
    return f"{x} / ({x} > {number(0.0, c.scalar)} ? {high} : {low})"


def redistribute(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
    """Statements of the cascade: thrusts beyond a limit freeze there, the others share the rest of tau."""
    if not (doubt := cascade_doubt(vehicle, c.scalar)) <= DOUBT[c.scalar]:
        finer = "generate it in double, or " if c.scalar == "float" else ""
        raise NotApplicable(
            f"{vehicle.name}: redistribute factorises T and H in the call, and in {c.scalar} that may cost"
            f" {doubt:.1g} of the largest limit; {finer}take nullspace, scaled or clip"
        )
    n, zero = vehicle.n, number(0.0, c.scalar)
    working = vehicle.working.tolist()
    ends = {i: bounds.ends(i) for i in working}
    arrays = {
        "low": [ends[i][0] if i in ends else zero for i in range(n)],
        "high": [ends[i][1] if i in ends else zero for i in range(n)],
        "g": [f"x{i}" if i in ends else zero for i in range(n)],
    }
    lines = [
        f"static const int working[{n}] = {{{', '.join(str(int(i in ends)) for i in range(n))}}};",
        *(f"{c.scalar} {name}[{n}] = {{{', '.join(values)}}};" for name, values in arrays.items()),
        "cascade(tau, low, high, working, g);",
    ]
    return _mended(vehicle, lines, {i: f"g[{i}]" for i in working}, bounds, c)


def cascade_doubt(vehicle: Vehicle, scalar: Scalar) -> float:
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


def cascade(vehicle: Vehicle, scalar: Scalar) -> str:
    """The functions that ``redistribute`` calls, with this vehicle's numbers in them."""
    text = (resources.files("alloc.native") / "cascade.c").read_text(encoding="utf-8")
    words = {
        "SCALAR": scalar,
        "K": str(vehicle.k),
        "N": str(vehicle.n),
        "ZERO": number(0.0, scalar),
        "ONE": number(1.0, scalar),
        "SPARE": number(SPARE[scalar] * vehicle.f_scale, scalar),
        "RANK": number(RANK[scalar] ** 2, scalar),
        "TP": _rows(vehicle.TP / vehicle.row_lengths[:, None], scalar),
        "HESSIAN": _rows(vehicle.H, scalar),
        "UNITS": _rows(1.0 / vehicle.row_lengths[None, :], scalar)[1:-1],
    }
    return re.sub(rf"\b({'|'.join(words)})\b", lambda word: words[word[0]], text)


def _rows(matrix: FloatArray, scalar: Scalar) -> str:
    rows = (", ".join(number(value, scalar) for value in row) for row in matrix.tolist())
    return "{" + ", ".join(f"{{{row}}}" for row in rows) + "}"


def _mended(
    vehicle: Vehicle, rule: list[str], thrusts: dict[int, str], bounds: CLimits, c: Table
) -> list[str]:
    """Statements that give f = T* tau, mended by a rule and cut at the limits, or refuse."""
    G = generalized_inverse(vehicle)
    seen = SeenArguments(cover(vehicle, G), bounds, c)
    lines = seen.add(vehicle.working.tolist(), "0")
    lines += refused(seen, [], crossed(bounds, c), c)
    more, met = _met(vehicle, G, c)
    definitions = [*read(vehicle, c), *closed_form(vehicle, G, "t", c), *bounds.definitions(), *more]
    lines += [*rule, *inside(thrusts, bounds, c), f"const int met = {met};", *written(vehicle, c)]
    return placed(definitions, [*lines, "return met ? SOLVED : PARTIAL;"])


def _met(vehicle: Vehicle, G: FloatArray, c: Table) -> tuple[list[str], str]:
    """Definitions of what T f misses of tau, relative to what it may, and the condition that it is met.

    T f - tau = T (f - T* tau) - (1 - T T*) tau, of which the last part is rounding where no rank is lost.
    """
    share = 1.0 / (MET[c.scalar] * vehicle.wrench_scale)[:, None]
    lines, rows, _ = product(share * vehicle.TP, "d", c, "q")
    sums, rows = butterflies(rows, c, "v")
    moved = [defined(f"d{i}", f"y{i} - x{i}", c) for i in vehicle.working.tolist()]
    if vehicle.rank < vehicle.k:
        more, lost, _ = product(share * (vehicle.TP @ G - np.eye(vehicle.k)), "t", c, "u")
        lines += more
        rows = [of_f + of_tau for of_f, of_tau in zip(rows, lost, strict=True)]
    missed = [defined(f"missed{r}", signed_sum(row, c.scalar), c) for r, row in enumerate(rows) if row]
    each = [f"missed{r}" for r, row in enumerate(rows) if row]
    one = number(1.0, c.scalar)
    condition = f"most({fold('most', each)}, -{fold('least', each)}) <= {one}" if each else "1"
    return [*moved, *lines, *sums, *missed], condition
