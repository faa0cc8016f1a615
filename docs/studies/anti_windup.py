"""Gain of an autopilot that listens to the delivered wrench: the table of docs/saturation.md.

``python docs/studies/anti_windup.py`` flies one step on four axes at once with a PID controller, on the body
of the missions, whose axes count as fixed here. ``priority`` allocates; thrusters saturate for seconds.
"""

import numpy as np

from alloc import Allocation, Vehicle, build, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE, FloatArray
from bench.demands import mission
from bench.results.text import table

STEP = {"surge": 8.0, "sway": -4.0, "heave": 3.0, "yaw": np.pi / 2}
"""Target, from rest [m, rad]."""
RATE_HZ, SECONDS = 100.0, 60.0
STIFFNESS, DAMPING, INTEGRAL = 1.5, 0.9, 0.15
"""Natural frequency [rad/s], damping ratio, and share of the stiffness that is integrated [1/s]."""
ALWAYS, SHARE, WRENCH, TRACK = RULES = (
    "integrates always",
    "holds where the share is below 1",
    "holds where the wrench differs",
    "tracks the delivered wrench",
)


def rate(
    rule: str, vehicle: Vehicle, error: FloatArray, tau: FloatArray, result: Allocation, gain: FloatArray
) -> FloatArray:
    """Rate (k,) of the integral under one of RULES, for a controller of that stiffness ``gain`` (k,)."""
    missed: FloatArray = vehicle.TP @ result.f - tau
    if rule == TRACK:
        return INTEGRAL * error + STIFFNESS * missed / gain
    whole = np.ones(vehicle.k, dtype=bool)
    if rule == SHARE:
        share = dict(zip(vehicle.priority, result.share, strict=True))
        whole = np.array([share[level] == 1.0 for axis in vehicle.dof for level in share if axis in level])
    elif rule == WRENCH:
        whole = np.abs(missed) <= WRENCH_TOLERANCE * vehicle.wrench_scale
    return np.where(whole, INTEGRAL * error, 0.0)


def fly(rule: str, vehicle: Vehicle, step: dict[str, float]) -> tuple[FloatArray, FloatArray]:
    """Positions and integrals (N, 6) on the way to that step from rest [m, rad]."""
    allocate = build("priority", vehicle)
    target = np.array([step.get(axis, 0.0) for axis in vehicle.dof])
    gain = mission.M * STIFFNESS**2
    place, v, integral = np.zeros(6), np.zeros(6), np.zeros(6)
    track, integrals = [], []
    for _ in range(int(SECONDS * RATE_HZ)):
        error = target - place
        tau = gain * (error + integral) - 2 * DAMPING * STIFFNESS * mission.M * v
        result = allocate(tau)
        integral = integral + rate(rule, vehicle, error, tau, result, gain) / RATE_HZ
        v = v + (vehicle.TP @ result.f - mission.resistance(v)) / mission.M / RATE_HZ
        place = place + v / RATE_HZ
        track.append(place)
        integrals.append(integral)
    return np.array(track), np.array(integrals)


def main() -> None:
    """Print overshoot and settling of each axis under each rule."""
    vehicle = load_vehicle("bluerov2-heavy")
    rows = []
    for rule in RULES:
        track, _ = fly(rule, vehicle, STEP)
        cells = []
        for axis, step in STEP.items():
            way = track[:, vehicle.dof.index(axis)] / step
            outside = np.flatnonzero(np.abs(way - 1) > 0.05)
            cells.append(f"{100 * (way.max() - 1):.0f} %, {(outside[-1] + 1) / RATE_HZ:.1f} s")
        rows.append([rule, *cells])
    print(table(["the integral", *STEP], rows))


if __name__ == "__main__":
    main()
