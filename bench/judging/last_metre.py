"""Loss between thrusts and thrusters: curves, dead bands and the step of a command."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from alloc import NotApplicable, Vehicle, alpha_max, build
from alloc.allocation import FloatArray
from bench.demands.mission import RATE_HZ, STEPS, Act, fly
from bench.judging.loss import relative_wrench_error
from bench.record import LastMetre

SHARES = (0.02, 0.05, 0.1)
"""Small demands: of what is attainable in their direction [-]."""
DIRECTIONS = 500
FLIGHT = STEPS[0]
"""Demands of the flight: the vehicle keeps station in a current, where thrusts are small."""
METHOD = "scaled"
"""Whose thrusts are sent: exact where a demand can be met, and it always answers."""

LINEAR = "linear map"
ROUNDING = 1e-9
"""Rounding by which a thrust made may exceed the demand [N]."""
Sends = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""A function of thrusts and limits (N, n) [N] that returns commands (N, n)."""


def ways(vehicle: Vehicle) -> dict[str, Sends]:
    """The ways from thrusts to commands that are compared, by what a report calls them."""
    jumps, stays = (with_dead_band(vehicle, jump=jump) for jump in (True, False))
    return {
        LINEAR: lambda f, low, high: linear_commands(vehicle, f),
        "curve, truncated": lambda f, low, high: truncated_commands(stays, f, low, high),
        "curve, neutral in the dead band": lambda f, low, high: stays.commands(f, f_min=low, f_max=high).u,
        "curve, dead band jumped": lambda f, low, high: jumps.commands(f, f_min=low, f_max=high).u,
    }


def with_dead_band(vehicle: Vehicle, *, jump: bool) -> Vehicle:
    """The vehicle with that policy in the dead band of each ESC."""
    made = {esc: replace(esc, jump=jump) for esc in dict.fromkeys(vehicle.esc)}
    return replace(vehicle, esc=tuple(made[esc] for esc in vehicle.esc))


def linear_commands(vehicle: Vehicle, f: FloatArray) -> FloatArray:
    """Commands (N, n) without a curve: linear from neutral to the limits, to the nearest step."""
    u = np.empty(f.shape)
    for i, esc in enumerate(vehicle.esc):
        least, most = min(float(vehicle.f_min[i]), 0.0), max(float(vehicle.f_max[i]), 0.0)
        full = np.where(f[:, i] < 0, least, most)
        share = np.divide(f[:, i], np.abs(full), out=np.zeros(len(f)), where=full != 0).clip(-1.0, 1.0)
        room = np.where((share < 0) != esc.reversed, esc.neutral - esc.low, esc.high - esc.neutral)
        along = np.rint(share * room / esc.step) * esc.step
        u[:, i] = esc.neutral + (-along if esc.reversed else along)
    return u


def truncated_commands(vehicle: Vehicle, f: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Commands (N, n) that code makes which turns a float into an integer: never more than was asked."""
    u, made, _ = vehicle.commands(f, f_min=low, f_max=high)
    steps, neutral = (np.array([getattr(esc, key) for esc in vehicle.esc]) for key in ("step", "neutral"))
    too_much = np.abs(made) > np.abs(f) + ROUNDING
    nearer: FloatArray = u - np.sign(u - neutral) * steps * too_much
    return nearer


def step_error(vehicle: Vehicle, taus: FloatArray, F: FloatArray) -> FloatArray:
    """The error (N,) that steps alone explain, relative to |tau|.

    A thrust that lies anywhere in a step of d_i newtons is off by d_i / sqrt(12) in the mean of squares, and
    thrusters by themselves, so |T S^-1 e|^2 is on average the sum of |T_i S^-1|^2 d_i^2 / 12, S the scale of
    wrenches.
    """
    steps = np.array([esc.step for esc in vehicle.esc])
    u = vehicle.commands(F).u
    d = np.abs(vehicle.thrusts(u + steps) - vehicle.thrusts(u - steps)) / 2
    columns = np.linalg.norm(vehicle.TP / vehicle.wrench_scale[:, None], axis=0)
    size = np.linalg.norm(taus / vehicle.wrench_scale, axis=1)
    error: FloatArray = np.sqrt((columns**2 * d**2 / 12).sum(axis=1)) / size
    return error


def last_metre(vehicle: Vehicle, seed: int) -> list[LastMetre]:
    """Cost of each way on small demands and in a flight; empty for a vehicle without ESCs.

    Raises NotApplicable where the method does not cover the vehicle.
    """
    if not vehicle.esc or any(esc.needs_volts for esc in vehicle.esc):
        return []
    allocate = build(METHOD, vehicle)
    towards = np.random.default_rng(seed).normal(size=(DIRECTIONS, vehicle.k)) * vehicle.wrench_scale
    edge = alpha_max(vehicle, towards)
    towards = (edge[:, None] * towards)[(edge > 0) & np.isfinite(edge)]
    ends = tuple(np.broadcast_to(side, (len(towards), vehicle.n)) for side in (vehicle.f_min, vehicle.f_max))
    by_share = {share: (share * towards, allocate.many(share * towards)[0]) for share in SHARES}
    found = []
    for name, sends in ways(vehicle).items():
        errors = {
            share: relative_wrench_error(vehicle, taus, vehicle.thrusts(sends(F, *ends)))
            for share, (taus, F) in by_share.items()
        }
        flown = _fly(vehicle, sends, seed, told=name != LINEAR)
        found.append(
            LastMetre(
                way=name,
                share=list(SHARES),
                error_p50=[float(np.median(error)) for error in errors.values()],
                error_p95=[float(np.quantile(error, 0.95)) for error in errors.values()],
                step_p50=[float(np.median(step_error(vehicle, *each))) for each in by_share.values()],
                **flown,
            )
        )
    return found


def _fly(vehicle: Vehicle, sends: Sends, seed: int, *, told: bool) -> dict[str, float | None]:
    """Record of a flight in which the thrusters make what is sent; None for a vehicle that can't fly it.

    Slew limits lie around what was made where the allocator is ``told``, else around what was asked.
    """
    allocate = build(METHOD, vehicle)
    previous = [np.clip(0.0, vehicle.f_min, vehicle.f_max)]
    sent, missed = list[FloatArray](), list[float]()

    def act(tau: FloatArray) -> FloatArray:
        slews = {} if vehicle.slew is None else {"f_previous": previous[-1], "dt": 1 / RATE_HZ}
        low, high = vehicle.limits(**slews)
        f = allocate(tau, low, high).f
        sent.append(sends(f[None], low[None], high[None])[0])
        made = vehicle.thrusts(sent[-1])
        previous.append(made if told else f)
        wrench: FloatArray = vehicle.TP @ made
        missed.append(float(np.linalg.norm((wrench - tau) / vehicle.wrench_scale)))
        return wrench

    acts: tuple[Act, Act] = (act, act)
    try:
        flight = fly(vehicle, vehicle, np.random.default_rng(seed), FLIGHT, FLIGHT, acts)
    except NotApplicable:
        return {"missed": None, "off_m": None, "turns_hz": None}
    off = np.linalg.norm((flight.setpoints - flight.poses)[:, :3], axis=1)
    neutral = np.array([esc.neutral for esc in vehicle.esc])
    ways_round = np.sign(np.array(sent) - neutral)
    turns = (np.diff(ways_round, axis=0) != 0).sum() / vehicle.n / (FLIGHT / RATE_HZ)
    return {
        "missed": float(np.median(missed)),
        "off_m": float(np.sqrt(np.mean(off**2))),
        "turns_hz": float(turns),
    }
