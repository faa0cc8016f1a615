"""Answers held against the optimum in exact arithmetic: ``python docs/studies/rational.py``.

The optimum is found in fractions, by the KKT conditions alone: from a guess of the thrusters at their limits,
one linear system gives thrusts and multipliers, and the guess is mended until every condition holds exactly.
That is done for eq. 4-5, for the soft problem, and without limits (eq. 6-7). Vehicles are odd
(``odd_vehicles``), in half of them T nearly loses rank, and of 20 demands the one is taken that leaves most
thrusters at their limits. ``--near`` takes vehicles that are symmetric but for their last digits, and demands
on their edges. What is printed is the largest distance of each method's answers to the optimum,
over the largest limit, by the condition of T, and how many lie farther off than their method promises.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import lcm
from typing import NamedTuple

import click
import numpy as np
from tabulate import tabulate

from alloc import AllocError, NotApplicable, Status, Vehicle, build, catalogue
from alloc.allocation import FloatArray
from alloc.formulations import Family
from alloc.reach.attainable import alpha_range
from alloc.vehicle.condition import condition
from bench.demands.near_degenerate import edge_demands, near_degenerate
from bench.demands.odd_vehicles import inside, odd_vehicle

Rows = list[list[Fraction]]
Limit = Fraction | None
ZERO = Fraction(0)
REPAIRS = 40
"""Most guesses of the thrusters at their limits; from a float answer one or two are enough."""
NEAR = 1e-6
"""Distance to a limit, over the largest limit, within which a float answer counts as at it."""
CHOICE = 20
"""Demands of a vehicle of which the hardest is taken."""
FAMILIES = (Family.EXACT, Family.LIVE, Family.ONE_SHOT, Family.SOFT, Family.CLOSED_FORM)


class ExactProblem(NamedTuple):
    """min 1/2 x'H x with A x = b and low <= x <= high, in fractions; None is no limit."""

    A: Rows
    H: Rows
    b: list[Fraction]
    low: list[Limit]
    high: list[Limit]


def fractions(array: FloatArray) -> Rows:
    """The entries of a matrix, exactly."""
    return [[Fraction(x) for x in row] for row in array.tolist()]


def problems(vehicle: Vehicle, tau: FloatArray) -> dict[str, ExactProblem]:
    """By formulation, the problem that the vehicle's numbers pose."""
    A, H, (b,) = fractions(vehicle.TP), fractions(vehicle.H), fractions(tau[None])
    (low,), (high,) = fractions(vehicle.f_min[None]), fractions(vehicle.f_max[None])
    free: list[Limit] = [None] * vehicle.k
    slack = np.hstack([vehicle.TP, -np.eye(vehicle.k)])
    zero = np.zeros((vehicle.n, vehicle.k))
    cost = np.block([[vehicle.H, zero], [zero.T, np.diag(vehicle.slack_weights)]])
    return {
        "hard": ExactProblem(A, H, b, [*low], [*high]),
        "soft": ExactProblem(fractions(slack), fractions(cost), b, [*low, *free], [*high, *free]),
        "unlimited": ExactProblem(A, H, b, [None] * vehicle.n, [None] * vehicle.n),
    }


def exact_optimum(problem: ExactProblem, guess: Sequence[float], near: float) -> list[Fraction] | None:
    """x of the problem's optimum, exactly; None where none is found from the guess."""
    A, H, b, low, high = problem
    at: dict[int, Fraction] = {}
    for i, (value, least, most) in enumerate(zip(guess, low, high, strict=True)):
        if least is not None and value - least <= near:
            at[i] = least
        elif most is not None and most - value <= near:
            at[i] = most
    n = len(H)
    for _ in range(REPAIRS):
        free = [i for i in range(n) if i not in at]
        # H_FF x_F + A_F'y = -H_FB x_B for the free variables, above A_F x_F = b - A_B x_B.
        system: Rows = [
            [*(H[i][j] for j in free), *(row[i] for row in A), -sum((H[i][j] * at[j] for j in at), ZERO)]
            for i in free
        ]
        system += [
            [*(row[j] for j in free), *[ZERO] * len(A), wanted - sum((row[j] * at[j] for j in at), ZERO)]
            for row, wanted in zip(A, b, strict=True)
        ]
        solution = solved(system)
        if solution is None:
            return None
        x, y = dict(zip(free, solution, strict=False)) | at, solution[len(free) :]
        if (out := worst({i: _beyond(x[i], low[i], high[i]) for i in free})) is not None:
            limit = low[out]
            at[out] = limit if limit is not None and x[out] < limit else _known(high[out])
            continue
        push = {
            i: sum((H[i][j] * x[j] for j in range(n)), ZERO)
            + sum((row[i] * y[r] for r, row in enumerate(A)), ZERO)
            for i in at
            if low[i] != high[i]
        }
        # At the lower limit the cost must not fall as x_i grows, at the upper one not as it shrinks.
        if (held := worst({i: -p if at[i] == low[i] else p for i, p in push.items()})) is None:
            return [x[i] for i in range(n)]
        del at[held]
    return None


def worst(by: dict[int, Fraction]) -> int | None:
    """The index of the largest number, None where none is positive."""
    largest = max(by, key=by.__getitem__, default=None)
    return largest if largest is not None and by[largest] > 0 else None


def _beyond(x: Fraction, low: Limit, high: Limit) -> Fraction:
    return max(ZERO if low is None else low - x, ZERO if high is None else x - high)


def _known(limit: Limit) -> Fraction:
    assert limit is not None
    return limit


def solved(system: Rows) -> list[Fraction] | None:
    """x of the square system [M | b], exactly; None where M is singular.

    Bareiss's elimination: all numbers stay whole, and every division has no rest, which saves the greatest
    common divisors that fractions would take at each step.
    """
    rows: list[list[int]] = []
    for equation in system:
        scale = lcm(*(x.denominator for x in equation))
        rows.append([x.numerator * (scale // x.denominator) for x in equation])
    size, before = len(rows), 1
    for column in range(size):
        pivot = next((r for r in range(column, size) if rows[r][column]), None)
        if pivot is None:
            return None
        rows[column], rows[pivot] = rows[pivot], rows[column]
        lead = rows[column]
        for r in range(column + 1, size):
            row = rows[r]
            rows[r] = [
                *([0] * (column + 1)),
                *(
                    (row[c] * lead[column] - row[column] * lead[c]) // before
                    for c in range(column + 1, size + 1)
                ),
            ]
        before = lead[column]
    x = [ZERO] * size
    for r in reversed(range(size)):
        known = sum((rows[r][c] * x[c] for c in range(r + 1, size)), ZERO)
        x[r] = (rows[r][-1] - known) / rows[r][r]
    return x


def nearly_singular(vehicle: Vehicle, rng: np.random.Generator, decades: float) -> Vehicle:
    """The vehicle with the smallest singular value of its T, in rows of unit length, that much smaller."""
    scale = vehicle.row_lengths[:, None]
    U, sigma, Vt = np.linalg.svd(vehicle.T / scale, full_matrices=False)
    sigma[-1] = sigma[0] * 10.0**-decades
    return replace(vehicle, T=(U * sigma) @ Vt * scale)


def hard_problem(
    trial: int, near_symmetric: bool = False
) -> tuple[Vehicle, FloatArray, dict[str, list[Fraction]]] | None:
    """A vehicle, its hardest demand (k,) [N, N m], and the optimum by formulation; None where it has none."""
    rng = np.random.default_rng([2004, trial])
    if near_symmetric:
        vehicle = near_degenerate(rng)
        taus = edge_demands(vehicle, rng, CHOICE)
    else:
        vehicle = odd_vehicle(rng)
        if rng.integers(2):
            vehicle = nearly_singular(vehicle, rng, rng.uniform(0, 8))
        taus = inside(vehicle, rng, CHOICE)
    least, most = alpha_range(vehicle, taus)
    inner = (least <= 1 - 1e-6) & (most >= 1 + 1e-6)
    F, status = build("qp/highs", vehicle).many(taus)
    near = NEAR * vehicle.f_scale
    known = inner & (status == Status.SOLVED)
    if vehicle.rank < vehicle.k or not known.any():
        return None
    held = ((F - vehicle.f_min <= near) | (vehicle.f_max - F <= near)).sum(axis=1)
    chosen = int(np.where(known, held, -1).argmax())
    posed = problems(vehicle, taus[chosen])
    f = exact_optimum(posed["hard"], F[chosen].tolist(), near)
    if f is None:
        return None
    found = {"hard": f}
    soft = build("qp-soft/daqp", vehicle)(taus[chosen]).f
    if np.isfinite(soft).all():
        x = [*soft.tolist(), *(vehicle.TP @ soft - taus[chosen]).tolist()]
        if (f := exact_optimum(posed["soft"], x, near)) is not None:
            found["soft"] = f[: vehicle.n]
    if (f := exact_optimum(posed["unlimited"], [0.0] * vehicle.n, near)) is not None:
        found["unlimited"] = f
    return vehicle, taus[chosen], found


@click.command()
@click.option("--problems", "wanted", default=1000, show_default=True)
@click.option("--seed", default=0, show_default=True)
@click.option("--near", is_flag=True, help="Vehicles that are nearly symmetric.")
def main(wanted: int, seed: int, near: bool) -> None:
    """Print the distance to the exact optimum, for each method that answers a problem with an optimum."""
    names = [e.name for e in catalogue() if e.family in FAMILIES and not e.missing and not e.twin]
    far: dict[tuple[str, str], float] = defaultdict(float)
    over: dict[str, int] = defaultdict(int)
    answers: dict[str, int] = defaultdict(int)
    done = trial = 0
    while done < wanted:
        trial += 1
        if (problem := hard_problem(seed + trial, near)) is None:
            continue
        done += 1
        vehicle, tau, optimum = problem
        decade = f"1e{np.ceil(np.log10(condition(vehicle))):.0f}"
        for name in names:
            try:
                allocate = build(name, vehicle)
            except (NotApplicable, AllocError):
                continue
            answer, right = allocate(tau), optimum.get(allocate.formulation)
            soft = allocate.formulation == "soft" and answer.status is Status.PARTIAL
            if right is None or not (soft or answer.status is Status.SOLVED):
                continue
            distance = max(abs(float(Fraction(a) - b)) for a, b in zip(answer.f.tolist(), right, strict=True))
            distance /= vehicle.f_scale
            far[name, decade] = max(far[name, decade], distance)
            answers[name] += 1
            over[name] += distance > allocate.tolerance
    decades = sorted({decade for _, decade in far}, key=float)
    rows = [
        [
            name,
            answers[name],
            over[name],
            *(f"{far[name, d]:.0e}" if (name, d) in far else "" for d in decades),
        ]
        for name in names
        if answers[name]
    ]
    click.echo(tabulate(rows, ["method", "answers", "beyond promise", *decades], tablefmt="github"))
    click.echo(f"{done} problems; {trial - done} left out: the rank is lost, or the optimum is degenerate")


if __name__ == "__main__":
    main()
