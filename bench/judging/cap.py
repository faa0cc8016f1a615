"""Cost of a cap on what all thrusters draw together, and the power that demands take.

All ways to keep a cap answer the same demands, which lie farther out than it allows, at one voltage.
``cap_excesses`` asks what happens while a cap sags in a mission, also behind a limiter that feeds the current
back.
"""

from functools import partial

import numpy as np

from alloc import AllocError, Vehicle, build
from alloc.allocation import FloatArray
from alloc.reach.volumes import uniform_demands
from bench.demands import DemandSet, build_demands
from bench.demands.strong import strong_vehicle, unasked_weak_axes
from bench.judging.judge import rounded
from bench.judging.last_metre import linear_commands
from bench.judging.loss import share_along
from bench.record import CapExcess, FuseCost, FuseWay, Power

POWER_DEMANDS = 100
"""Most demands that are asked, evenly out of all: a linear program takes milliseconds."""
MISSIONS = ("mission", "mission-fault")


def missions_power(vehicle: Vehicle, volts: float, seed: int) -> list[Power]:
    """Mean powers over the missions at one voltage [V], without those that do not cover the vehicle."""
    found = []
    for name in MISSIONS:
        try:
            demands = build_demands(name, vehicle, seed)
            seconds = np.full(len(demands.taus), 1.0 / (demands.rate_hz or 1.0))
            power = mean_power(demands, volts, seconds)
        except AllocError:
            continue
        found += [] if power is None else [power]
    return found


def mean_power(demands: DemandSet, volts: float, seconds: FloatArray) -> Power | None:
    """Mean power of ``scaled`` and ``frugal``, which make the same wrenches, at one voltage [V].

    Demands hold for ``seconds`` (N,). None where none is answered, or nothing is drawn. Raises AllocError
    for a vehicle without currents, and one that a method does not cover.
    """
    vehicle, draw = demands.vehicle, demands.vehicle.draw(volts)
    pick = np.unique(np.linspace(0, len(demands.taus) - 1, POWER_DEMANDS).astype(int))
    ends = (side if side.ndim == 1 else side[pick] for side in demands.limits)
    limits = vehicle.esc_limits(volts, *ends)
    F, _ = build("scaled", vehicle).many(demands.taus[pick], *limits)
    lean, _ = build("frugal", vehicle).many(demands.taus[pick], *limits, volts=volts)
    answered = np.isfinite(F).all(axis=1) & np.isfinite(lean).all(axis=1)
    if not answered.any():
        return None
    held = seconds[pick][answered]
    watts, least = (volts * held @ draw.amps(f[answered]).sum(axis=1) / held.sum() for f in (F, lean))
    if not watts > 0.0:
        return None
    return Power(
        demands=demands.name,
        n=int(answered.sum()),
        seconds=rounded(seconds.sum()),
        effort_W=rounded(watts),
        least_W=rounded(least),
    )


def energy_lines(demands: DemandSet, seconds: FloatArray | None) -> list[tuple[str, str]]:
    """A line of ``thrustbench demands`` on the energy of a log; none without a cap, a voltage or times."""
    cap = demands.vehicle.cap
    if cap is None or cap.volts is None or seconds is None:
        return []
    try:
        power = mean_power(demands, cap.volts, seconds)
    except AllocError:  # too many facets
        return []
    if power is None:
        return []
    return [(f"energy at {cap.volts:g} V", f"{power.words}, by {power.n:,} of {len(demands.taus):,} demands")]


SET = "mission"
SAG = 0.6
"""Part of the file's cap that is left when the mission ends; it falls evenly [-]."""
TIME_CONSTANT = 5.0
"""MOT_BAT_CURR_TC where nobody sets it [s]."""
AHEAD, FAST, BRAKE = 5.0, 1.5, 2.5
"""Loops of the prediction, p above which the limiter brakes, and r then."""

WITHIN = "scaled, within the cap, rounded to commands"
FEEDBACK = "scaled, ArduSub's current limiter behind it"
WITHOUT = "scaled, without"
MIXED = "ArduSub's mixer and current limiter, outputs linear in pulses"


def output_factor(factor: float, amps: float, before: float, most: float, dt: float) -> float:
    """ArduSub's factor of all outputs after a loop of dt [s] with these currents, of now and before [A].

    ArduSub's limiter (ArduPilot, AP_Motors6DOF.cpp, parameters MOT_BAT_CURR_MAX and MOT_BAT_CURR_TC)
    multiplies all pulses, counted from neutral, by a factor between 0 and 1. With the measured current I over
    the largest allowed as r, and I + 5 (I - I of the loop before) over it as p, each loop of dt adds
    dt / (dt + TC) (1 - r); r becomes 2.5 where p exceeds 1.5, else p where I is below the largest and p above
    1. So the current exceeds the cap first, and the factor follows in seconds.
    """
    r, p = amps / most, (amps + AHEAD * (amps - before)) / most
    if p > FAST:
        r = BRAKE
    elif r < 1.0 < p:
        r = p
    return float(np.clip(factor + dt / (dt + TIME_CONSTANT) * (1.0 - r), 0.0, 1.0))


def limiter_thrusts(vehicle: Vehicle, u: FloatArray, caps: FloatArray, volts: float, dt: float) -> FloatArray:
    """Thrusts (N, n) [N] of commands u (N, n) behind the limiter, with caps (N,) [A] and loops of dt [s]."""
    neutral = np.array([esc.neutral for esc in vehicle.esc])
    full, draw = u - neutral, vehicle.draw(volts)
    made = np.empty(u.shape)
    factor, amps, before = 1.0, 0.0, 0.0
    for i, most in enumerate(caps.tolist()):
        factor, before = output_factor(factor, amps, before, most, dt), amps
        made[i] = vehicle.thrusts(neutral + factor * full[i], volts)
        amps = float(draw.amps(made[i]).sum())
    return made


def cap_excesses(vehicle: Vehicle, seed: int) -> list[CapExcess]:
    """Excess over a cap that falls from the file's to SAG of it over the mission, by each way to keep it.

    Empty for a vehicle without a cap or a voltage, and one that can't fly the mission.
    """
    if vehicle.cap is None or (volts := vehicle.cap.volts) is None:
        return []
    try:
        demands = build_demands(SET, vehicle, seed)
        limits, draw, allocate = vehicle.esc_limits(volts), vehicle.draw(volts), build("scaled", vehicle)
    except AllocError:
        return []
    taus, dt = demands.taus, 1.0 / (demands.rate_hz or 1.0)
    caps = vehicle.cap.amps() * np.linspace(1.0, SAG, len(taus))
    F = allocate.many(taus, *limits)[0]
    answers = (allocate(tau, *limits, cap=cap, volts=volts) for tau, cap in zip(taus, caps, strict=True))
    within = np.array([answer.f for answer in answers])
    ways = {
        WITHIN: vehicle.commands(within, volts, f_min=limits[0], f_max=limits[1], cap=caps).f,
        FEEDBACK: limiter_thrusts(vehicle, vehicle.commands(F, volts).u, caps, volts, dt),
        WITHOUT: F,
    }
    if vehicle.autopilot is not None and vehicle.autopilot.method == "ardusub":
        mixed = build("ardusub", vehicle).many(taus)[0]
        pulses = vehicle.commands(mixed).u if vehicle.autopilot.curve else linear_commands(vehicle, mixed)
        ways[MIXED] = limiter_thrusts(vehicle, pulses, caps, volts, dt)
    found = []
    for way, made in ways.items():
        over = draw.amps(made).sum(axis=1) - caps
        shares = share_along(*demands.strong, made, limits)
        found.append(
            CapExcess(
                way=way,
                over_A=rounded(max(float(over.max()), 0.0)),
                over_share=rounded(np.mean(over > 0.0)),
                share_p50=rounded(np.nanmedian(shares)),
                share_min=rounded(np.nanmin(shares)),
            )
        )
    return found


DIRECTIONS = 100
"""Directions of demands: a median share of them is within a point or two of that of all."""
BEYOND = 100.0
"""Size of a demand, in the vehicle's ``wrench_scale``: no cap and no limit reaches as far."""

LARGEST = "frugal, the largest there is"
PATH = "scaled, least effort up to the cap"
RATIO = "all thrusts by one ratio"
EACH = "each thruster at its part of the cap"
WAYS = {LARGEST: "frugal", PATH: "scaled", RATIO: "cap-by-ratio", EACH: "cap-by-thruster"}
"""The method of each way."""


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
        methods = {way: build(method, vehicle) for way, method in WAYS.items()}
        drawn = uniform_demands(strong_vehicle(vehicle), np.random.default_rng(seed), DIRECTIONS)
    except AllocError:  # no voltage, or too many facets
        return None
    axes = np.vstack([np.eye(vehicle.k), -np.eye(vehicle.k)]) * vehicle.wrench_scale
    axes, found = stretch_demands(vehicle, axes), []
    compared = compare_ways(vehicle, unasked_weak_axes(vehicle, drawn))
    for name, method in methods.items():
        shares, over = compared[name]
        # An axis may be out of reach.
        made = [vehicle.TP @ method(tau, *limits, cap=amps, volts=volts).f for tau in axes]
        ends = np.hstack([np.diag(each) for each in np.split(np.nan_to_num(made), 2)[::-1]])
        found.append(
            FuseWay(
                way=name,
                share_p50=rounded(np.median(shares)),
                share_min=rounded(shares.min()),
                amps_p50=rounded(np.median(over)),
                amps_max=rounded(over.max()),
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


def compare_ways(vehicle: Vehicle, taus: FloatArray) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Shares (N,) over the largest, and currents (N,) over the least, by way, of demands along taus (N, k).

    The cap is that of the vehicle's file. Raises AllocError for a vehicle that a way does not cover.
    """
    assert vehicle.cap is not None
    amps, volts = vehicle.cap.amps(), vehicle.cap.volts
    draw, limits = vehicle.draw(volts), vehicle.esc_limits(volts)
    asked, least = stretch_demands(vehicle, taus), build("frugal", vehicle)
    found, largest = {}, np.ones(len(taus))
    for name, method in WAYS.items():
        allocate = partial(build(method, vehicle), f_min=limits[0], f_max=limits[1], cap=amps, volts=volts)
        answers = [allocate(tau) for tau in asked]
        F, shares = np.array([one.f for one in answers]), np.array([one.share[0] for one in answers])
        largest = shares if name == LARGEST else largest
        lean = [least(tau, *limits, volts=volts).f for tau in shares[:, None] * asked]
        over = draw.amps(F).sum(axis=1) / draw.amps(np.array(lean)).sum(axis=1)
        found[name] = shares / largest, over
    return found


def stretch_demands(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """Demands (N, k) along these, BEYOND on their largest axis."""
    size = np.abs(taus / vehicle.wrench_scale).max(axis=1, keepdims=True)
    beyond: FloatArray = BEYOND * taus / size
    return beyond
