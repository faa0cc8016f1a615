"""Answers held against the optimum in exact arithmetic: ``python docs/studies/rational.py``.

The optimum is found in fractions, for eq. 4-5, for the soft problem, and without limits (eq. 6-7). Vehicles
are odd (``odd_vehicles``), in half of them T nearly loses rank, and of 20 demands the one is taken that
leaves most thrusters at their limits. ``--near`` takes vehicles that are symmetric but for their last
digits, and demands near their edges; ``--edge`` demands on the very edge that, in fractions, can be met:
there the optimum may move by far more than the demand does. What is printed is the largest distance of each
method's answers to the optimum, over the largest limit, by the condition of T, how many lie farther off than
their method promises, and the most effort above the least, relative to it.
"""

from collections import defaultdict
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
from bench.demands.generated import edge_demands, inside, near_degenerate, odd_vehicle

Rows = list[list[Fraction]]
Limit = Fraction | None
ZERO = Fraction(0)
NEAR = 1e-6
"""Distance to a limit, over the largest limit, within which a thruster counts as at it."""
ON_EDGE = 1e-12
"""|alpha - 1| of a demand on the very edge of what a vehicle can do: rounding alone."""
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


def exact_optimum(problem: ExactProblem) -> list[Fraction] | None:
    """x of the problem's optimum, exactly; None where nothing is inside its limits.

    The dual active set of Goldfarb and Idnani (1983): from the optimum without limits, the limit that is
    missed most is held next, and those that stand in its way are let go. Each step makes the optimum dearer,
    so no set of held limits comes twice.
    """
    A, H, b, low, high = problem
    n = len(H)
    rows = independent(A, b)
    if rows is None:
        return None

    def step(held: dict[int, Fraction], i: int | None, side: int) -> tuple[list[Fraction], list[Fraction]]:
        """Move of x where limit i pulls by one and the held ones stay, and the fall of their multipliers."""
        equal = [A[r] for r in rows] + [[Fraction(each == j) for each in range(n)] for j in held]
        wanted = [ZERO if i is not None else b[r] for r in rows] + [ZERO] * len(held)
        system = [[*H[r], *(row[r] for row in equal), Fraction(side * (r == i))] for r in range(n)]
        system += [[*row, *[ZERO] * len(equal), at] for row, at in zip(equal, wanted, strict=True)]
        solution = solved(system)
        assert solution is not None, "the rows that are held hang together"
        return solution[:n], solution[n + len(rows) :]

    x, _ = step({}, None, 0)
    held: dict[int, Fraction] = {}  # multiplier by the variable that is at a limit
    sides: dict[int, int] = {}
    while (i := worst({j: _beyond(x[j], low[j], high[j]) for j in range(n)})) is not None:
        limit = low[i]
        sides[i] = 1 if limit is not None and x[i] < limit else -1
        end = _known(limit if sides[i] == 1 else high[i])
        pull, taken = ZERO, False
        while not taken:
            along, falls = step(held, i, sides[i])
            fall = {j: sides[j] * each for j, each in zip(held, falls, strict=True)}
            stays = {j: held[j] / each for j, each in fall.items() if each > 0}
            ways = [
                *((t, j) for j, t in stays.items()),
                *([((end - x[i]) / along[i], i)] if along[i] else []),  # no way where x_i can't move
            ]
            if not ways:
                return None
            size, stop = min(ways)
            x = [at + size * d for at, d in zip(x, along, strict=True)]
            held = {j: u - size * fall[j] for j, u in held.items()}
            pull += size
            taken = stop == i
            if not taken:
                del held[stop]
        held[i] = pull
    return x


def independent(A: Rows, b: list[Fraction]) -> list[int] | None:
    """Rows of A x = b that say all that the others do; None where they contradict each other."""
    kept, reduced = list[int](), list[tuple[int, list[Fraction]]]()
    for i, (row, wanted) in enumerate(zip(A, b, strict=True)):
        rest = [*row, wanted]
        for column, lead in reduced:
            rest = [x - rest[column] / lead[column] * y for x, y in zip(rest, lead, strict=True)]
        column = next((j for j, x in enumerate(rest) if x), len(row) + 1)
        if column == len(row):
            return None
        if column < len(row):
            kept.append(i)
            reduced.append((column, rest))
    return kept


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
    trial: int, near_symmetric: bool = False, edge: bool = False
) -> tuple[Vehicle, FloatArray, dict[str, list[Fraction]]] | None:
    """A vehicle, its hardest demand (k,) [N, N m], and the optimum by formulation; None where it has none."""
    rng = np.random.default_rng([2004, trial])
    if near_symmetric or edge:
        vehicle = near_degenerate(rng)
        taus = edge_demands(vehicle, rng, CHOICE)
    else:
        vehicle = odd_vehicle(rng)
        if rng.integers(2):
            vehicle = nearly_singular(vehicle, rng, rng.uniform(0, 8))
        taus = inside(vehicle, rng, CHOICE)
    if vehicle.rank < vehicle.k:
        return None
    least, most = alpha_range(vehicle, taus)
    inner = (least <= 1 - 1e-6) & (most >= 1 + 1e-6)
    if edge:
        chosen = np.flatnonzero((np.abs(least - 1) <= ON_EDGE) | (np.abs(most - 1) <= ON_EDGE)).tolist()
    else:
        F, status = build("qp/highs", vehicle).many(taus)
        near = NEAR * vehicle.f_scale
        held = ((F - vehicle.f_min <= near) | (vehicle.f_max - F <= near)).sum(axis=1)
        known = inner & (status == Status.SOLVED)
        chosen = [int(np.where(known, held, -1).argmax())] if known.any() else []
    for i in chosen:
        found = {name: exact_optimum(problem) for name, problem in problems(vehicle, taus[i]).items()}
        if found["hard"] is not None:
            return vehicle, taus[i], {name: x[: vehicle.n] for name, x in found.items() if x is not None}
    return None


def effort(vehicle: Vehicle, f: list[Fraction]) -> Fraction:
    """f'Hf, exactly."""
    H = fractions(vehicle.H)
    return sum((h * x * y for row, x in zip(H, f, strict=True) for h, y in zip(row, f, strict=True)), ZERO)


@click.command()
@click.option("--problems", "wanted", default=1000, show_default=True)
@click.option("--seed", default=0, show_default=True)
@click.option("--near", is_flag=True, help="Vehicles that are nearly symmetric.")
@click.option("--edge", is_flag=True, help="The same, and demands on the very edge.")
@click.option("--method", "only", multiple=True, help="Only this method; of all that are no twins else.")
def main(wanted: int, seed: int, near: bool, edge: bool, only: tuple[str, ...]) -> None:
    """Print the distance to the exact optimum, for each method that answers a problem with an optimum."""
    names = only or [e.name for e in catalogue() if e.family in FAMILIES and not (e.missing or e.twin)]
    far: dict[tuple[str, str], float] = defaultdict(float)
    dearer: dict[str, float] = defaultdict(float)
    over: dict[str, int] = defaultdict(int)
    answers: dict[str, int] = defaultdict(int)
    done = trial = 0
    while done < wanted:
        trial += 1
        if (problem := hard_problem(seed + trial, near, edge)) is None:
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
            if allocate.formulation == "hard":
                above = effort(vehicle, fractions(answer.f[None])[0]) - (least := effort(vehicle, right))
                dearer[name] = max(dearer[name], float(above / least) if least else 0.0)
            answers[name] += 1
            over[name] += distance > allocate.tolerance
    decades = sorted({decade for _, decade in far}, key=float)
    rows = [
        [
            name,
            answers[name],
            over[name],
            f"{dearer[name]:.0e}" if name in dearer else "",
            *(f"{far[name, d]:.0e}" if (name, d) in far else "" for d in decades),
        ]
        for name in names
        if answers[name]
    ]
    click.echo(
        tabulate(rows, ["method", "answers", "beyond promise", "more effort", *decades], tablefmt="github")
    )
    click.echo(f"{done} problems; {trial - done} left out: the rank is lost, or none such is met")


if __name__ == "__main__":
    main()
