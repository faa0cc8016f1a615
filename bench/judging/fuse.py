"""Cost of a cap on what all thrusters draw together, by each way to keep it.

A way is a function of a demand that lies farther out than the cap allows: thrusts within the cap, and their
share of the demand. All ways answer the same demands, at one voltage.
"""

from collections.abc import Callable

import numpy as np

from alloc import AllocError, Vehicle, build
from alloc.allocation import FloatArray
from alloc.nullspace.current_cap import reaches
from alloc.reach.volumes import uniform_demands
from alloc.vehicle.current import Draw
from alloc.vehicle.limits import Interval
from bench.demands.strong import strong_vehicle, unasked_weak_axes
from bench.judging.energy import missions_power
from bench.judging.judge import rounded
from bench.judging.sagging_cap import SAG, cap_excesses
from bench.record import FuseCost, FuseWay

DIRECTIONS = 100
"""Directions of demands: a median share of them is within a point or two of that of all."""
BEYOND = 100.0
"""Size of a demand, in the vehicle's ``wrench_scale``: no cap and no limit reaches as far."""
HALVINGS = 60
"""Halvings of a limit: they leave less than its last bit."""

LARGEST = "frugal, the largest there is"
PATH = "scaled, least effort up to the cap"
RATIO = "all thrusts by one ratio"
EACH = "each thruster at its part of the cap"
Way = Callable[[FloatArray], tuple[FloatArray, float]]
"""A function of a demand (k,) that returns thrusts (n,) [N] within the cap and their share of it [-]."""


def each_at(draw: Draw, limits: Interval, amps: float) -> Interval:
    """Limits (n,) at which each thruster draws so many amperes, or its own where these draw less [N]."""
    nearer = []
    for side in limits:
        least, most = np.zeros(len(side)), np.ones(len(side))
        for _ in range(HALVINGS):
            middle = (least + most) / 2
            fits = draw.amps(middle * side) <= amps
            least, most = np.where(fits, middle, least), np.where(fits, most, middle)
        nearer.append(least * side)
    return nearer[0], nearer[1]


def ways(vehicle: Vehicle, limits: Interval, amps: float, volts: float | None) -> dict[str, Way]:
    """Ways to keep all currents together below a cap [A] within limits (n,) [N], at a voltage [V].

    Thrusters must be able to stand still. Raises AllocError for a vehicle that a way does not cover.
    """
    scaled, frugal, draw = build("scaled", vehicle), build("frugal", vehicle), vehicle.draw(volts)
    parts = each_at(draw, limits, amps / len(vehicle.working))
    rest = np.zeros(vehicle.n)

    def largest(tau: FloatArray) -> tuple[FloatArray, float]:
        found = frugal(tau, *limits, cap=amps, volts=volts)
        return found.f, found.share[0]

    def along_path(tau: FloatArray) -> tuple[FloatArray, float]:
        found = scaled(tau, *limits, cap=amps, volts=volts)
        return found.f, found.share[0]

    def by_ratio(tau: FloatArray) -> tuple[FloatArray, float]:
        found = scaled(tau, *limits)
        ratio = reaches(draw, amps, rest, found.f)
        return ratio * found.f, ratio * found.share[0]

    def each_apart(tau: FloatArray) -> tuple[FloatArray, float]:
        found = scaled(tau, *parts)
        return found.f, found.share[0]

    return {LARGEST: largest, PATH: along_path, RATIO: by_ratio, EACH: each_apart}


def fuse_cost(vehicle: Vehicle, seed: int) -> FuseCost | None:
    """Cost of the cap of a vehicle's file at its nominal voltage, reproducible from the seed.

    None for a vehicle without a cap or a voltage, one whose thrusters can't all stand still, and one that a
    way does not cover.
    """
    if vehicle.cap is None or (vehicle.f_min > 0.0).any() or (vehicle.f_max < 0.0).any():
        return None
    amps, volts = vehicle.cap.amps(), vehicle.cap.volts
    try:
        draw, limits = vehicle.draw(volts), vehicle.esc_limits(volts)
        answers = ways(vehicle, limits, amps, volts)
        drawn = uniform_demands(strong_vehicle(vehicle), np.random.default_rng(seed), DIRECTIONS)
    except AllocError:  # no voltage, or too many facets
        return None
    axes = np.vstack([np.eye(vehicle.k), -np.eye(vehicle.k)]) * vehicle.wrench_scale
    asked, axes = far(vehicle, unasked_weak_axes(vehicle, drawn)), far(vehicle, axes)
    least = build("frugal", vehicle)
    found, largest = [], np.ones(DIRECTIONS)
    for name, way in answers.items():
        f, shares = map(np.array, zip(*map(way, asked), strict=True))
        largest = shares if name == LARGEST else largest
        lean = [least(tau, *limits, volts=volts).f for tau in shares[:, None] * asked]
        over = draw.amps(f).sum(axis=1) / draw.amps(np.array(lean)).sum(axis=1)
        made = np.nan_to_num([vehicle.TP @ way(tau)[0] for tau in axes])  # an axis may be out of reach
        ends = np.hstack([np.diag(made[vehicle.k :]), np.diag(made)])
        found.append(
            FuseWay(
                way=name,
                share_p50=rounded(float(np.median(shares / largest))),
                share_min=rounded(float((shares / largest).min())),
                amps_p50=rounded(float(np.median(over))),
                amps_max=rounded(float(over.max())),
                axis_min=list(map(rounded, ends[: vehicle.k].tolist())),
                axis_max=list(map(rounded, ends[vehicle.k :].tolist())),
            )
        )
    return FuseCost(
        amps=rounded(amps),
        volts=volts,
        most=rounded(draw.largest(*limits)),
        n_demands=DIRECTIONS,
        ways=found,
        powers=[] if volts is None else missions_power(vehicle, volts, seed),
        excesses=cap_excesses(vehicle, seed),
        last_amps=rounded(SAG * amps),
    )


def far(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """Demands (N, k) along these, BEYOND on their largest axis."""
    size = np.abs(taus / vehicle.wrench_scale).max(axis=1, keepdims=True)
    beyond: FloatArray = BEYOND * taus / size
    return beyond
