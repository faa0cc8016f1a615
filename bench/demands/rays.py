"""Rays of attainable demands, and how far along each the closed form and the vehicle can go."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from alloc import NotApplicable, Vehicle
from alloc.allocation import FloatArray
from alloc.reach.attainable import alpha_range, closed_form_range
from bench.demands.strong import strong_vehicle

BATCHES = 100
"""Draws of n rays before a set counts as impossible: below one usable ray in a hundred it may be missed."""


class Rays(NamedTuple):
    """Demands tau of random thrusts, and the ranges of their multiples that can be served.

    Attributes
    ----------
    taus : (N, k) demands [N, N m]
    attainable : least and largest alpha, (N,) each, with alpha tau attainable [-]
    closed : least and largest alpha, (N,) each, with alpha T* tau inside the limits [-]; (inf, -inf) where
        there is none
    """

    taus: FloatArray
    attainable: tuple[FloatArray, FloatArray]
    closed: tuple[FloatArray, FloatArray]


def draw(vehicle: Vehicle, rng: np.random.Generator, n: int) -> Rays:
    """n rays through T P f, f uniform inside the limits, without weak directions.

    Raises NotApplicable where every such wrench is zero, as for thrusters held at thrusts that cancel.
    """
    vehicle = strong_vehicle(vehicle)
    taus = random_thrusts(vehicle, rng, n) @ vehicle.TP.T
    attainable = alpha_range(vehicle, taus)
    if not np.isfinite(attainable[1]).all():
        raise NotApplicable(f"{vehicle.name}: the limits leave no wrench but zero; give thrusters a choice")
    return Rays(taus, attainable, closed_form_range(vehicle, taus))


def random_thrusts(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n thrusts (n, n) uniform within limits; of a thruster that turns a random mean of its corners [N]."""
    f = rng.uniform(vehicle.f_min, vehicle.f_max, size=(n, vehicle.n))
    for azimuth in vehicle.turning:
        each = [rng.dirichlet(np.ones(len(part.corners)), n) @ part.corners for part in azimuth.parts]
        chosen = rng.integers(len(each), size=n) if len(each) > 1 else np.zeros(n, dtype=np.intp)
        f[:, azimuth.components] = np.stack(each)[chosen, np.arange(n)]
    return f


def collect(
    vehicle: Vehicle,
    rng: np.random.Generator,
    n: int,
    pick: Callable[[Rays], tuple[FloatArray, FloatArray]],
    absent: str,
) -> FloatArray:
    """n demands, each a ray's tau times a factor uniform in the range (low, high) that ``pick`` gives.

    Rays whose range is empty (low >= high) are drawn anew. Raises NotApplicable with the reason
    ``absent`` where BATCHES draws leave fewer than n rays.
    """
    batches: list[FloatArray] = []
    count = 0
    for _ in range(BATCHES):
        rays = draw(vehicle, rng, n)
        low, high = pick(rays)
        with np.errstate(invalid="ignore"):
            usable = low < high
        factor = rng.uniform(low[usable], high[usable])
        batches.append(rays.taus[usable] * factor[:, None])
        count += int(usable.sum())
        if count >= n:
            return np.concatenate(batches)[:n]
    raise NotApplicable(f"{vehicle.name}: {absent}")
