"""Power that demands take by least effort, and at least current: the cost of the effort's weights."""

import numpy as np

from alloc import AllocError, Vehicle, build
from alloc.allocation import FloatArray
from bench.demands import DemandSet, build_demands
from bench.judging.judge import rounded
from bench.record import Power

MOST = 100
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
    pick = np.unique(np.linspace(0, len(demands.taus) - 1, MOST).astype(int))
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
        seconds=rounded(float(seconds.sum())),
        effort_W=rounded(float(watts)),
        least_W=rounded(float(least)),
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
    return [] if power is None else [(f"energy at {cap.volts:g} V", power.words)]
