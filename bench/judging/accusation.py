"""Time until the monitor of ``codegen --monitor`` accuses a thruster that is off, from its own arithmetic.

Thruster i is off and noise is as stated. Of thrusts that are told, running sums with forgetting over turns of
(f_i - mean f_i) (f_j - mean f_j) a_i . a_j (``alloc.c.suspicion``) are the pushes s_ij along each thruster j,
and d_i = s_ii. The losses that explain them are l_i = 1 - SLIGHT and l_j = (s_ij - SLIGHT d_j) / d_j, so log
odds are (l_i^2 d_i - l_j^2 d_j) / (2 INFLATION) on average. Noise that keeps rho = exp(-TURNS / LASTING) of
itself from turn to turn moves pushes along i and j with the covariance V_ij, the sum of these products with
rho^turns over all pairs of turns, and log odds with the variance (l_i^2 V_ii + l_j^2 V_jj - 2 l_i l_j V_ij) /
INFLATION^2. The normal tail gives how often they exceed ACCUSED; stretches of demands are averaged. All
thrusters are taken to have their turn at once.
"""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.c.suspicion import ACCUSED, KEPT, LASTING, LEAST, SLIGHT, TURNS, inflation
from alloc.closed_forms.inverse import generalized_inverse

LIVELY = 0.4
"""Largest demand of an axis, of what all thrusters push there; its root mean square is 16 % of that [-]."""
PERIODS_S = 1.5, 8.0
"""Shortest and longest period of the waves that demands are the means of [s]."""
WAVES = 3
RATE_HZ = 50.0
"""Calls a second, at which LASTING is half a second."""
SOON_S, LATE_S = 10.0, 60.0
"""Time in which a failure is told soon, and time after which nobody waits: three times MEMORY [s]."""
ASSUMED = (
    f"at {RATE_HZ:g} calls a second and demands that wander on each axis, by 16 % of what thrusters push"
    " together (root mean square) in 1.5 to 8 s (assumed; --demands states others)"
)
"""Words for demands that nobody states."""
STRETCHES = 100
SURELY = 0.95
"""Share of stretches in which the thruster is accused in the time that is said."""


def random_waves(rng: np.random.Generator, stretches: int, k: int) -> tuple[FloatArray, FloatArray]:
    """Periods [s] and phases [rad] (WAVES, stretches, k) of wandering demands."""
    shape = WAVES, stretches, k
    return rng.uniform(*PERIODS_S, shape), rng.uniform(0, 2 * np.pi, shape)


def wandering_demands(vehicle: Vehicle, waves: tuple[FloatArray, FloatArray], t: FloatArray) -> FloatArray:
    """Demands (N, stretches, k) at times t (N,) [s]: the mean of sines of these periods and phases."""
    periods, phases = waves
    sines = np.sin(2 * np.pi * t[:, None, None, None] / periods + phases)
    demands: FloatArray = largest_demands(vehicle) * sines.mean(axis=1)
    return demands


def largest_demands(vehicle: Vehicle) -> FloatArray:
    """Largest wandering demand (k,) of each axis [N, N m]."""
    farthest = np.maximum(np.abs(vehicle.f_min), np.abs(vehicle.f_max))
    largest: FloatArray = LIVELY * np.abs(vehicle.TP) @ farthest
    return largest


def _stretches(rows: FloatArray, calls: int) -> FloatArray:
    """Stretches (calls, STRETCHES, m) of rows (N, m), from other starts, in a ring."""
    starts = np.linspace(0, len(rows), STRETCHES, endpoint=False, dtype=int)
    return rows[(np.arange(calls)[:, None] + starts) % len(rows)]


def times_of_thrusters(
    vehicle: Vehicle,
    noise: FloatArray,
    taus: FloatArray | None = None,
    rate_hz: float = RATE_HZ,
    limits: tuple[FloatArray, FloatArray] | tuple[None, None] = (None, None),
) -> FloatArray:
    """Time (n,) after which thruster i, off, is accused in SURELY of stretches of demands [s].

    ``taus`` (N, k) are demands call by call [N, N m], ``limits`` f_min and f_max (N, n) of these calls [N],
    None: the vehicle's; without ``taus`` demands wander. Thrusts are T* tau within limits.
    """
    calls, (low, high) = int(LATE_S * rate_hz), (vehicle.f_min, vehicle.f_max)
    if taus is None:
        waves = random_waves(np.random.default_rng(0), STRETCHES, vehicle.k)
        demands = wandering_demands(vehicle, waves, np.arange(calls) / rate_hz)
    else:
        calls = min(calls, len(taus))
        demands = _stretches(taus, calls)
        if limits[0] is not None:
            low, high = (_stretches(side, calls) for side in limits)
    G = generalized_inverse(vehicle.strong if vehicle.weak_left.any() else vehicle)
    F = np.clip(demands @ G.T, low, high)
    return seconds_to_accuse(accused_shares(vehicle, noise, np.swapaxes(F, 0, 1)), rate_hz)


def accused_shares(
    vehicle: Vehicle, noise: FloatArray, F: FloatArray, lasting: float = LASTING
) -> FloatArray:
    """Share (N, n) of stretches in which thruster i, off, is accused after each call.

    F (stretches, N, n) are thrusts that are told [N], ``noise`` (k,) that of a wrench [N, N m], which lasts
    ``lasting`` calls.
    """
    from scipy.special import ndtr

    columns = vehicle.TP / noise[:, None]
    products, on, rho = columns.T @ columns, np.arange(vehicle.n), np.exp(-TURNS / lasting)
    sums, moved = np.zeros((2, len(F), vehicle.n + 1, vehicle.n + 1))
    before = np.zeros((len(F), vehicle.n + 1))
    shares = np.zeros(F.shape[1:])
    for call in range(0, F.shape[1] - TURNS + 1, TURNS):
        f = np.pad(F[:, call], ((0, 0), (0, 1)), constant_values=1.0)
        told, follows = f[:, :, None] * f[:, None, :], f[:, :, None] * before[:, None, :]
        sums = KEPT * sums + told
        moved = KEPT**2 * moved + told + follows + np.swapaxes(follows, 1, 2)
        before = KEPT * rho * (before + f)
        means = sums[:, -1] / sums[:, -1, -1:]
        push, V = (products * _about(means, each) for each in (sums, moved))
        d = push[:, on, on] + LEAST
        own = ((1.0 - SLIGHT) * push[:, on, on] / d)[:, :, None]
        other = np.maximum(push / d[:, None, :] - SLIGHT, 0.0)
        other[:, on, on] = 0.0  # no failure at all
        gap = (own**2 * d[:, :, None] - other**2 * d[:, None, :]) / 2.0 - inflation(lasting) * ACCUSED
        size = V[:, on, on]
        spread = own**2 * size[:, :, None] + other**2 * size[:, None, :] - 2.0 * own * other * V
        share = ndtr((gap / np.sqrt(np.maximum(spread, 1e-9))).min(axis=2)).mean(axis=0)
        shares[call + TURNS - 1 : call + 2 * TURNS - 1] = share
    return shares


def _about(means: FloatArray, sums: FloatArray) -> FloatArray:
    """Sums (D, n, n) of products of thrusts about means, of sums (D, n + 1, n + 1) whose last is a 1."""
    f = means[:, :-1]
    ones = f[:, :, None] * sums[:, -1:, :-1]
    about: FloatArray = sums[:, :-1, :-1] - ones - np.swapaxes(ones, 1, 2)
    about += sums[:, -1:, -1:] * f[:, :, None] * f[:, None, :]
    return about


def as_text(vehicle: Vehicle, seconds: FloatArray, demands: str, lasting_s: float = LATE_S) -> str:
    """Lines of ``check --failures``: the time of each thruster, then how many are told soon.

    ``demands`` says which these are, ``lasting_s`` how long they last [s].
    """
    on = vehicle.working.tolist()
    lines = [
        f"told     {vehicle.called(i)}: "
        + (
            f"if it is off, accused after {seconds[i]:.3g} s"
            if np.isfinite(seconds[i])
            else f"not surely accused in {min(lasting_s, LATE_S):.3g} s"
        )
        for i in on
    ]
    soon = sum(seconds[i] <= SOON_S for i in on)
    lines.append(
        f"soon     {soon} of {len(on)} thrusters within {SOON_S:g} s, in {100 * SURELY:g} % of cases, by"
        f" codegen --monitor, {demands}; noise lasts {LASTING} calls"
    )
    return "\n".join(lines)


def seconds_to_accuse(shares: FloatArray, rate_hz: float = RATE_HZ) -> FloatArray:
    """Time (n,) after which a thruster is accused in SURELY of stretches [s]; infinite where it never is."""
    surely = shares >= SURELY
    return np.where(surely.any(axis=0), (surely.argmax(axis=0) + 1) / rate_hz, np.inf)
