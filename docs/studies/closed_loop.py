"""What a method costs a vehicle that flies with it: ``python docs/studies/closed_loop.py [VEHICLE] [--esc]``.

Every method lives with its own last answer: the next call's limits are what slew rates leave around it, and
the vehicle's autopilot answers to what its thrusters did. Half a second into a turn a thruster fails. The
study prints a table of ``docs/limits.md``; a comparison with one method's numbers alone would say little, so
``scaled`` flies the same missions: exact where the demand can be met, else its largest share. With ``--esc``
only ``scaled`` flies, through each way to the vehicle's ESCs, and slew limits lie around what those made,
as far as a curve tells: the table of ``results/studies/closed_loop.md``.
"""

import sys
from dataclasses import dataclass, field

import numpy as np

from alloc import NotApplicable, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.reach.volumes import worst_fault
from bench.demands.mission import HALF, RATE_HZ, STEPS, Act, Flight, fly
from bench.judging.last_metre import LINEAR, METHOD, ways
from bench.results.text import table, three

METHODS = (
    "scaled",
    "priority",
    "nullspace",
    "qp-soft/daqp",
    "redistribute",
    "shrink",
    "clip",
    "desaturate",
    "fixed-point",
    "pinv",
)
FLIGHTS = 10
FAILURE = STEPS[3] + 50
"""Half a second after a new waypoint, heading included, is given: the vehicle is turning."""
ARRIVED_M, ARRIVED_DEG = 0.3, 5.0
"""A vehicle this near its setpoint, in position and in each angle, has recovered."""


@dataclass
class Crew:
    """Thrusters that a method commands, and what came of it.

    Attributes
    ----------
    f : (n,) thrusts that slew limits lie around [N]: those made, as far as the vehicle knows
    missed : of each demand, |T P f - tau| in wrench_scale [-]
    """

    f: FloatArray
    missed: list[float] = field(default_factory=list)

    def act(self, method: str, vehicle: Vehicle, way: str = "") -> Act:
        """Force on the vehicle where the method answers; where it has no answer, thrusts stay.

        With a way to the ESCs (``last_metre.ways``) thrusters make what that sends; the linear map, which has
        no curve, takes what was asked for made.
        """
        allocate = build(method, vehicle)
        sends = ways(vehicle)[way] if way else None

        def act(tau: FloatArray) -> FloatArray:
            low, high = vehicle.limits(f_previous=self.f, dt=1 / RATE_HZ)
            wanted = allocate(tau, low, high).f
            self.f = np.clip(wanted if np.isfinite(wanted).all() else self.f, low, high)
            made = self.f
            if sends is not None:
                made = vehicle.thrusts(sends(self.f[None], low[None], high[None])[0])
                self.f = self.f if way == LINEAR else made
            wrench: FloatArray = vehicle.TP @ made
            self.missed.append(float(np.linalg.norm((wrench - tau) / vehicle.wrench_scale)))
            return wrench

        return act


@dataclass(frozen=True)
class Flown:
    """One mission with one method.

    Attributes
    ----------
    mean, worst : share of the wrench that was not delivered, over the mission and at the worst moment [-]
    off_m, off_deg : root mean square distance from the setpoint, and of the largest angle to it
    recovery_s : from the failure until the vehicle has arrived and stays; infinite where it does not
    """

    mean: float
    worst: float
    off_m: float
    off_deg: float
    recovery_s: float


def mission(method: str, vehicle: Vehicle, seed: int, way: str = "") -> Flown:
    """Fly one mission, with a way to the ESCs or without.

    Raises NotApplicable where the method or the mission does not cover the vehicle.
    """
    degraded = vehicle.with_fault(worst_fault(vehicle, keep_rank=True))
    crew = Crew(np.clip(0.0, vehicle.f_min, vehicle.f_max))
    acts = crew.act(method, vehicle, way), crew.act(method, degraded, way)
    flight = fly(vehicle, degraded, np.random.default_rng(seed), 2 * HALF, FAILURE, acts)
    metres, degrees = errors(flight)
    return Flown(
        mean=float(np.mean(crew.missed)),
        worst=float(np.max(crew.missed)),
        off_m=float(np.sqrt(np.mean(metres**2))),
        off_deg=float(np.sqrt(np.mean(degrees**2))),
        recovery_s=recovery(metres[FAILURE : STEPS[4]], degrees[FAILURE : STEPS[4]]),
    )


def errors(flight: Flight) -> tuple[FloatArray, FloatArray]:
    """Distance from the setpoint (N,) [m], and the largest angle to it (N,) [deg]."""
    off = flight.setpoints - flight.poses
    turned = np.abs((off[:, 3:] + np.pi) % (2 * np.pi) - np.pi)
    return np.linalg.norm(off[:, :3], axis=1), np.degrees(turned).max(axis=1)


def recovery(metres: FloatArray, degrees: FloatArray) -> float:
    """Time [s] after which both errors stay small; infinite where they do not."""
    away = np.flatnonzero((metres > ARRIVED_M) | (degrees > ARRIVED_DEG))
    if not away.size:
        return 0.0
    return float((away[-1] + 1) / RATE_HZ) if away[-1] + 1 < len(metres) else float("inf")


def main(arguments: list[str]) -> None:
    """Print the table: medians over FLIGHTS missions, and how many of them recovered."""
    named = [each for each in arguments if each != "--esc"]
    vehicle = load_vehicle(named[0] if named else "bluerov2-heavy")
    flights = [(method, method, "") for method in METHODS]
    if "--esc" in arguments:
        flights = [("thrusts as allocated", METHOD, ""), *((way, METHOD, way) for way in ways(vehicle))]
    rows = []
    for label, method, way in flights:
        try:
            flown = [mission(method, vehicle, seed, way) for seed in range(FLIGHTS)]
        except NotApplicable as reason:
            print(f"left out: {reason}")
            continue
        mean, off_m, off_deg = (
            three(float(np.median([getattr(outcome, key) for outcome in flown])))
            for key in ("mean", "off_m", "off_deg")
        )
        worst = three(max(outcome.worst for outcome in flown))
        recovered = sorted(outcome.recovery_s for outcome in flown if np.isfinite(outcome.recovery_s))
        median = three(float(np.median(recovered))) if recovered else "-"
        rows.append((label, mean, worst, off_m, off_deg, median, f"{len(recovered)} of {FLIGHTS}"))
    header = (
        "way" if "--esc" in arguments else "method",
        "missed, mean",
        "worst",
        "off, m",
        "off, deg",
        "recovery, s",
        "recovered",
    )
    print(f"{vehicle.name}, {FLIGHTS} missions of a minute, a thruster fails in a turn\n")
    print(table(header, rows))


if __name__ == "__main__":
    main(sys.argv[1:])
