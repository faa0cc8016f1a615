"""Answers held against the optimum in exact arithmetic: ``python -m bench.studies.rational``.

The optimum of eq. 4-5 is found in fractions, by the KKT conditions alone: from a guess of the thrusters at
their limits, one linear system gives thrusts and multipliers, and the guess is mended until every condition
holds exactly. What is printed is the largest distance of each method's SOLVED answers to that, over the
largest limit, by the condition of T, and how many answers lie farther off than their method promises.
"""

from collections import defaultdict
from dataclasses import replace
from fractions import Fraction

import click
import numpy as np
from tabulate import tabulate

from alloc import (
    AllocError,
    Family,
    FloatArray,
    NotApplicable,
    Status,
    Vehicle,
    alpha_range,
    build,
    catalogue,
)
from alloc.vehicle.condition import condition
from bench.studies.odd_vehicles import inside, odd_vehicle

Rows = list[list[Fraction]]
ZERO = Fraction(0)
REPAIRS = 40
"""Most guesses of the thrusters at their limits; from a float answer one or two are enough."""
NEAR = 1e-6
"""Distance to a limit, over the largest limit, within which a float answer counts as at it."""


def exact_optimum(vehicle: Vehicle, tau: FloatArray, guess: FloatArray) -> list[Fraction] | None:
    """f (n,) that solves eq. 4-5 for these floating-point numbers exactly; None where none is found."""
    T = [[Fraction(x) for x in row] for row in vehicle.TP.tolist()]
    H = [[Fraction(x) for x in row] for row in vehicle.H.tolist()]
    low, high = ([Fraction(x) for x in side.tolist()] for side in (vehicle.f_min, vehicle.f_max))
    wanted = [Fraction(x) for x in tau.tolist()]
    k, n = vehicle.k, vehicle.n
    near = NEAR * vehicle.f_scale
    at = {i: low[i] for i in range(n) if guess[i] - vehicle.f_min[i] <= near}
    at |= {i: high[i] for i in range(n) if i not in at and vehicle.f_max[i] - guess[i] <= near}
    for _ in range(REPAIRS):
        free = [i for i in range(n) if i not in at]
        # H_FF f_F + T_F'y = -H_FB f_B for the free thrusters, above T_F f_F = tau - T_B f_B.
        system: Rows = [
            [
                *(H[i][j] for j in free),
                *(T[r][i] for r in range(k)),
                -sum((H[i][j] * at[j] for j in at), ZERO),
            ]
            for i in free
        ]
        system += [
            [*(T[r][j] for j in free), *[ZERO] * k, wanted[r] - sum((T[r][j] * at[j] for j in at), ZERO)]
            for r in range(k)
        ]
        solution = solved(system)
        if solution is None:
            return None
        f = dict(zip(free, solution, strict=False)) | at
        y = solution[len(free) :]
        beyond = {i: max(low[i] - f[i], f[i] - high[i]) for i in free}
        worst = max(beyond, key=beyond.__getitem__, default=None)
        if worst is not None and beyond[worst] > 0:
            at[worst] = low[worst] if f[worst] < low[worst] else high[worst]
            continue
        push = {
            i: sum(H[i][j] * f[j] for j in range(n)) + sum(T[r][i] * y[r] for r in range(k))
            for i in at
            if low[i] < high[i]
        }
        # At the lower limit the cost must not fall as f_i grows, at the upper one not as it shrinks.
        wrong = {i: -p if at[i] == low[i] else p for i, p in push.items()}
        worst = max(wrong, key=wrong.__getitem__, default=None)
        if worst is None or wrong[worst] <= 0:
            return [f[i] for i in range(n)]
        del at[worst]
    return None


def solved(system: Rows) -> list[Fraction] | None:
    """x of the square system [M | b], in fractions; None where M is singular."""
    size = len(system)
    for column in range(size):
        pivot = next((r for r in range(column, size) if system[r][column]), None)
        if pivot is None:
            return None
        system[column], system[pivot] = system[pivot], system[column]
        lead = system[column]
        for r in range(column + 1, size):
            if factor := system[r][column]:
                factor /= lead[column]
                system[r] = [a - factor * b if b else a for a, b in zip(system[r], lead, strict=True)]
    x = [ZERO] * size
    for r in reversed(range(size)):
        x[r] = (system[r][-1] - sum(system[r][c] * x[c] for c in range(r + 1, size))) / system[r][r]
    return x


def nearly_singular(vehicle: Vehicle, rng: np.random.Generator, decades: float) -> Vehicle:
    """The vehicle with the smallest singular value of its T, in rows of unit length, that much smaller."""
    scale = vehicle.row_lengths[:, None]
    U, sigma, Vt = np.linalg.svd(vehicle.T / scale, full_matrices=False)
    sigma[-1] = sigma[0] * 10.0**-decades
    return replace(vehicle, T=(U * sigma) @ Vt * scale)


@click.command()
@click.option("--problems", default=1000, show_default=True)
@click.option("--seed", default=0, show_default=True)
def main(problems: int, seed: int) -> None:
    """Print the distance to the exact optimum, for each method that answers eq. 4-5."""
    names = [e.name for e in catalogue() if e.family in (Family.EXACT, Family.LIVE) and not e.missing]
    worst: dict[tuple[str, str], float] = defaultdict(float)
    over: dict[str, int] = defaultdict(int)
    answers: dict[str, int] = defaultdict(int)
    done = skipped = 0
    trial = seed
    while done < problems:
        trial += 1
        rng = np.random.default_rng(trial)
        vehicle = odd_vehicle(rng)
        if rng.integers(2):
            vehicle = nearly_singular(vehicle, rng, rng.uniform(0, 8))
        if vehicle.rank < vehicle.k:
            continue
        tau = inside(vehicle, rng, 1)[0]
        least, most = alpha_range(vehicle, tau[None])
        inner = least[0] <= 1 - 1e-6 and most[0] >= 1 + 1e-6
        guess = build("qp/highs", vehicle)(tau)
        known = inner and guess.status is Status.SOLVED
        f = exact_optimum(vehicle, tau, guess.f) if known else None
        if f is None:
            skipped += 1
            continue
        done += 1
        decade = f"cond(T) 1e{np.ceil(np.log10(condition(vehicle))):.0f}"
        for name in names:
            try:
                allocate = build(name, vehicle)
                answer = allocate(tau)
            except (NotApplicable, AllocError):
                continue
            if answer.status is not Status.SOLVED or allocate.formulation != "hard":
                continue
            distance = max(abs(float(Fraction(a) - b)) for a, b in zip(answer.f.tolist(), f, strict=True))
            distance /= vehicle.f_scale
            worst[name, decade] = max(worst[name, decade], distance)
            answers[name] += 1
            over[name] += distance > allocate.tolerance
    decades = sorted({decade for _, decade in worst})
    rows = [
        [
            name,
            answers[name],
            over[name],
            *(f"{worst[name, d]:.0e}" if (name, d) in worst else "" for d in decades),
        ]
        for name in names
    ]
    click.echo(tabulate(rows, ["method", "SOLVED", "beyond promise", *decades], tablefmt="github"))
    click.echo(f"{done} problems; {skipped} left out, whose optimum is degenerate or on the edge")


if __name__ == "__main__":
    main()
