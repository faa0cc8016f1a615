"""What an autopilot gains by listening to the delivered share: the table of docs/saturation.md.

``python docs/studies/anti_windup.py`` flies one step on four axes at once with a PID controller, on the body
of the missions, whose axes count as fixed here. ``priority`` allocates; thrusters saturate for seconds.
"""

import numpy as np

from alloc import Allocation, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from bench.demands import mission
from bench.results.text import table

STEP = {"surge": 8.0, "sway": -4.0, "heave": 3.0, "yaw": np.pi / 2}
"""From rest [m, rad]."""
RATE_HZ, SECONDS = 100.0, 60.0
STIFFNESS, DAMPING, INTEGRAL = 1.5, 0.9, 0.15
"""Natural frequency [rad/s], damping ratio, and share of the stiffness that is integrated [1/s]."""
RULES = ("integrates always", "holds the levels whose share is below 1", "tracks the delivered wrench")


def rate(
    rule: str, vehicle: Vehicle, error: FloatArray, tau: FloatArray, result: Allocation, gain: FloatArray
) -> FloatArray:
    """Rate (k,) of the integral under one of RULES, for a controller of that stiffness ``gain`` (k,)."""
    if rule == RULES[1]:
        served = {
            axis: s == 1.0 for level, s in zip(vehicle.priority, result.share, strict=True) for axis in level
        }
        return np.where([served[axis] for axis in vehicle.dof], INTEGRAL * error, 0.0)
    if rule == RULES[2]:
        missed: FloatArray = vehicle.TP @ result.f - tau
        return INTEGRAL * error + STIFFNESS * missed / gain
    return INTEGRAL * error


def fly(rule: str) -> FloatArray:
    """Positions (N, k) on the way to STEP [m, rad]."""
    vehicle = load_vehicle("bluerov2-heavy")
    allocate = build("priority", vehicle)
    target = np.array([STEP.get(axis, 0.0) for axis in vehicle.dof])
    gain = mission.M * STIFFNESS**2
    place, v, integral = np.zeros(6), np.zeros(6), np.zeros(6)
    track = []
    for _ in range(int(SECONDS * RATE_HZ)):
        error = target - place
        tau = gain * (error + integral) - 2 * DAMPING * STIFFNESS * mission.M * v
        result = allocate(tau)
        integral = integral + rate(rule, vehicle, error, tau, result, gain) / RATE_HZ
        v = v + (vehicle.TP @ result.f - mission.resistance(v)) / mission.M / RATE_HZ
        place = place + v / RATE_HZ
        track.append(place)
    return np.array(track)


def main() -> None:
    """Print overshoot and settling of each axis under each rule."""
    dof = load_vehicle("bluerov2-heavy").dof
    rows = []
    for rule in RULES:
        track = fly(rule)
        cells = []
        for axis, step in STEP.items():
            way = track[:, dof.index(axis)] / step
            outside = np.flatnonzero(np.abs(way - 1) > 0.05)
            cells.append(f"{100 * (way.max() - 1):.0f} %, {(outside[-1] + 1) / RATE_HZ:.1f} s")
        rows.append([rule, *cells])
    print(table(["the integral", *STEP], rows))


if __name__ == "__main__":
    main()
