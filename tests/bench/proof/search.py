"""A search for attainable demands with large rounding errors: the worst so far, changed many times."""

from typing import Any

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.program import Program, Scalar, answered, values
from bench.demands.corners import thrusts
from bench.proof.rounding.claims import KINDS, apart
from bench.proof.source import ANSWERED

RUNS, ROUNDS, DEMANDS, KEPT = 20, 100, 3_000, 100
"""How often it begins anew at most, with rounds of so many demands, each made of the worst before it."""
FINEST: dict[Scalar, float] = {"double": -16.0, "float": -7.0}
"""Size of the smallest change, of all of a range: its logarithm."""


def largest_error(program: Program, vehicle: Vehicle, scalar: Scalar, enough: float) -> float:
    """The largest error found [N], of demands that take the same branches as in real numbers.

    The search begins anew until an error of ``enough`` is found. A demand is known by thrusts within the
    limits that make it; they change by up to all of their range or by its last bit, some of them or all.
    """
    found = 0.0
    for run in range(RUNS):
        if found < enough:
            found = max(found, _one(program, vehicle, scalar, np.random.default_rng(1961 + run)))
    return found


def _one(program: Program, vehicle: Vehicle, scalar: Scalar, rng: np.random.Generator) -> float:
    low, high = vehicle.f_min[:, None], vehicle.f_max[:, None]
    f = thrusts(vehicle, rng, DEMANDS)
    errors = _errors(program, vehicle, f, KINDS[scalar])
    for _ in range(ROUNDS):
        worst = np.argsort(-errors)[:KEPT]
        f, errors = f[:, worst], errors[worst]
        size = (high - low) * 10.0 ** rng.uniform(FINEST[scalar], 0.0, DEMANDS)
        some = rng.random((vehicle.n, DEMANDS)) < rng.uniform(0.1, 1.0, DEMANDS)
        steps = size * rng.standard_normal((vehicle.n, DEMANDS)) * some
        made = np.clip(f[:, rng.integers(0, KEPT, DEMANDS)] + steps, low, high)
        f = np.concatenate([f, made], axis=1)
        errors = np.concatenate([errors, _errors(program, vehicle, made, KINDS[scalar])])
    return float(errors.max())


def _errors(program: Program, vehicle: Vehicle, f: FloatArray, kinds: tuple[Any, Any]) -> FloatArray:
    """(N,) errors; zero where a demand is refused, or takes other branches than in real numbers."""
    inputs = {"tau": (vehicle.TP @ f).astype(kinds[0])}
    some, true = (values(program, inputs, kind) for kind in kinds)
    got = answered(program, some, f.shape[1])
    off, same = apart(program, got, some, true)
    errors: FloatArray = np.where(same & np.isin(got.status, ANSWERED), off.astype(float), 0.0)
    return errors
