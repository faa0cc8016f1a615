"""A mission under a cap that sags: allocation within it, beside a limiter that feeds the current back.

ArduSub's limiter (ArduPilot, AP_Motors6DOF.cpp, parameters MOT_BAT_CURR_MAX and MOT_BAT_CURR_TC) multiplies
all pulses, counted from neutral, by a factor between 0 and 1. With the measured current I over the largest
allowed as r, and I + 5 (I - I of the loop before) over it as p, each loop of dt adds dt / (dt + TC) (1 - r);
r becomes 2.5 where p exceeds 1.5, else p where I is below the largest and p above 1. So the current exceeds
the cap first, and the factor follows in seconds.
"""

import numpy as np

from alloc import AllocError, Vehicle, build
from alloc.allocation import FloatArray
from bench.demands import build_demands
from bench.judging.judge import rounded
from bench.judging.last_metre import linear
from bench.judging.loss import share_along
from bench.record import CapExcess

SET = "mission"
SAG = 0.6
"""Part of the file's cap that is left when the mission ends; it falls evenly [-]."""
STEP = 10
"""Distance between the demands that are answered and counted: a call with a cap takes milliseconds."""
TIME_CONSTANT = 5.0
"""MOT_BAT_CURR_TC where nobody sets it [s]."""
AHEAD, FAST, BRAKE = 5.0, 1.5, 2.5
"""Loops of the prediction, p above which the limiter brakes, and r then."""

WITHIN = "scaled, within the cap, rounded to commands"
FEEDBACK = "scaled, ArduSub's current limiter behind it"
WITHOUT = "scaled, without"
MIXED = "ArduSub's mixer and current limiter, outputs linear in pulses"


def output_factor(factor: float, amps: float, before: float, most: float, dt: float) -> float:
    """ArduSub's factor of all outputs after a loop of dt [s] with these currents, of now and before [A]."""
    r, p = amps / most, (amps + AHEAD * (amps - before)) / most
    if p > FAST:
        r = BRAKE
    elif r < 1.0 < p:
        r = p
    return float(np.clip(factor + dt / (dt + TIME_CONSTANT) * (1.0 - r), 0.0, 1.0))


def fed_back(vehicle: Vehicle, u: FloatArray, caps: FloatArray, volts: float, dt: float) -> FloatArray:
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
    counted = slice(None, None, STEP)
    within = np.array(
        [
            allocate(tau, *limits, cap=cap, volts=volts).f
            for tau, cap in zip(taus[counted], caps[counted], strict=True)
        ]
    )
    ways = {
        WITHIN: vehicle.commands(within, volts, f_min=limits[0], f_max=limits[1], cap=caps[counted]).f,
        FEEDBACK: fed_back(vehicle, vehicle.commands(F, volts).u, caps, volts, dt)[counted],
        WITHOUT: F[counted],
    }
    if vehicle.autopilot is not None and vehicle.autopilot.method == "ardusub":
        pulses = linear(vehicle, build("ardusub", vehicle).many(taus)[0])
        ways[MIXED] = fed_back(vehicle, pulses, caps, volts, dt)[counted]
    found = []
    for way, made in ways.items():
        over = draw.amps(made).sum(axis=1) - caps[counted]
        shares = share_along(demands.strong[0], demands.strong[1][counted], made, limits)
        found.append(
            CapExcess(
                way=way,
                over_A=rounded(max(float(over.max()), 0.0)),
                over_share=rounded(float(np.mean(over > 0.0))),
                share_p50=rounded(float(np.nanmedian(shares))),
                share_min=rounded(float(np.nanmin(shares))),
            )
        )
    return found
