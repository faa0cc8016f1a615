"""A search for attainable demands with large rounding errors: the worst so far, changed many times."""

from typing import Any

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.program import Node, Program, Scalar, answered, values
from bench.demands.corners import thrusts
from bench.proof.rounding.claims import KINDS, apart

RUNS = 20
ROUNDS = 100
DEMANDS = 3_000
"""Of each round."""
FINEST: dict[Scalar, float] = {"double": -16.0, "float": -7.0}
"""Size of the smallest change, of all of a range: its logarithm."""
KEPT = 100
"""Demands that those of the next round are made of."""


def searched(
    program: Program,
    vehicle: Vehicle,
    scalar: Scalar,
    exact: dict[Node, float],
    enough: float,
    runs: int = RUNS,
) -> float:
    """The largest error found [N], of demands that take the same branches as in real numbers.

    It begins anew up to ``runs`` times, until an error of ``enough`` is found. A demand is known by thrusts
    within the limits that make it; they change by up to all of their range or by its last bit, some of them
    or all.
    """
    found = 0.0
    for run in range(runs):
        if found < enough:
            found = max(found, _searched(program, vehicle, scalar, exact, np.random.default_rng(1961 + run)))
    return found


def _searched(
    program: Program,
    vehicle: Vehicle,
    scalar: Scalar,
    exact: dict[Node, float],
    rng: np.random.Generator,
) -> float:
    narrow, wide = KINDS[scalar]
    low, high = vehicle.f_min[:, None], vehicle.f_max[:, None]
    f = thrusts(vehicle, rng, DEMANDS)
    errors = _errors(program, vehicle, f, (narrow, wide), exact)
    for _ in range(ROUNDS):
        worst = np.argsort(-errors)[:KEPT]
        f, errors = f[:, worst], errors[worst]
        size = (high - low) * 10.0 ** rng.uniform(FINEST[scalar], 0.0, DEMANDS)
        some = rng.random((vehicle.n, DEMANDS)) < rng.uniform(0.1, 1.0, DEMANDS)
        steps = size * rng.standard_normal((vehicle.n, DEMANDS)) * some
        made = np.clip(f[:, rng.integers(0, KEPT, DEMANDS)] + steps, low, high)
        f = np.concatenate([f, made], axis=1)
        errors = np.concatenate([errors, _errors(program, vehicle, made, (narrow, wide), exact)])
    return float(errors.max())


def _errors(
    program: Program,
    vehicle: Vehicle,
    f: FloatArray,
    kinds: tuple[Any, Any],
    exact: dict[Node, float],
) -> FloatArray:
    """(N,) errors; zero where a demand is refused, or takes other branches than in real numbers."""
    narrow, wide = kinds
    inputs = {"tau": (vehicle.TP @ f).astype(narrow)}
    some, true = values(program, inputs, narrow), values(program, inputs, wide, exact)
    got = answered(program, some, f.shape[1])
    off, same = apart(program, got, some, true)
    errors: FloatArray = np.where(same & ((got.status == 0) | (got.status == 1)), off.astype(float), 0.0)
    return errors
