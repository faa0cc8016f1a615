"""Equations of the C that accuses thrusters (``alloc.c.monitor``), and what it answers, in Python.

A thruster i that loses the share l of its thrust leaves the residual r = T f - wrench = l f_i T_i; a current,
a trim or a bias leave a steady one, b. With a_i = T_i over the noise of a wrench, and r and b likewise,
running sums over calls with forgetting, of f_i a_i . r, f_i^2, f_i, r and 1, give the least squares of l f_i
T_i + b: s_i = sum of (f_i - mean f_i) a_i . (r - mean r) and d_i = sum of (f_i - mean f_i)^2 a_i . a_i, which
no b changes. The loss is s_i / d_i, the score (s_i - SLIGHT d_i)^2 / d_i, by how much it explains the
residuals better than noise, b and a SLIGHT loss do. Steady sums cancel, so what rounding may leave of them,
``sums_rounding`` of each, is taken off s_i and added to d_i. Thrusters take TURNS, so that a call costs less:
noise lasts longer than a turn. Noise follows itself: with rho = exp(-TURNS / LASTING) of it kept from turn to
turn, a weighted sum of it has at most INFLATION = (1 + rho) / (1 - rho) times the variance of independent
noise (its power density at zero frequency), so half the score over INFLATION is a log-likelihood. The
thruster with the largest score is the most likely one, and the log of its odds against the next, or against
no failure, is the difference.

For a healthy vehicle and thrusts that do not follow the noise, (s_i - SLIGHT d_i) / sqrt(INFLATION d_i) is
normal, with a mean of at most 0 and a variance of at most 1. So log odds exceed h in one call by chance with
a probability of at most n Q(sqrt(2 h)), Q the normal tail; the sum over calls bounds accusations in a dive.
"""

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.c.target import NOT_FINITE
from alloc.errors import AllocError
from alloc.program import Scalar
from alloc.vehicle import Vehicle
from alloc.vehicle.geometry import unit

LASTING = 25
"""Calls after which noise has 1 / e of itself left: half a second at 50 Hz. Simulated vehicles
(docs/studies/dives.py) keep an error of drag for 0.4 to 0.75 s, by axis."""
MEMORY = 1024
"""Calls after which a residual counts 1 / e: 20 s at 50 Hz, so that 10 s are little forgotten."""
SLIGHT = 0.25
"""Loss of a thruster that errors of drag may feign; no thruster is accused of less [-]."""
TURNS = 2
"""Calls in which each thruster has its turn once; the first ones come first."""
KEPT = 1.0 - TURNS / MEMORY
ACCUSED = 20.0
"""Log odds from which a thruster is accused: Q(sqrt(40)) = 1.3e-10, so up to 20 thrusters and 100 calls a
second make less than one false accusation in a thousand hours."""
NOBODY = -1
"""Answer where no loss of any thruster explains a residual."""
LEAST = 1.0
"""Added to d_i, which prevents a division by zero; a thruster that shows has thousands [-]."""
WRENCHES = 100.0
"""Most residual that is taken, relative to the largest wrench that limits allow [-]."""
FINEST = 1e-6
"""Least noise, of the most that thrusters together push on an axis: squares stay within single precision."""


def check_noise(vehicle: Vehicle, noise: FloatArray, lasting: float = LASTING) -> None:
    """Raise AllocError unless noise (k,) lasts a call, and is not too fine for single precision."""
    if not 1.0 <= lasting < np.inf:
        raise AllocError(f"--lasting: got {lasting:g} calls, expected 1 or more")
    finest = FINEST * _most(vehicle)
    for axis, size, least in zip(vehicle.dof, noise.tolist(), finest.tolist(), strict=True):
        if not (least < size < np.inf):
            raise AllocError(f"--noise: {axis}: got {size:g} {unit(axis)}, expected more than {least:.2g}")


def accusations(
    vehicle: Vehicle,
    noise: FloatArray,
    F: FloatArray,
    wrenches: FloatArray,
    lasting: float = LASTING,
    scalar: Scalar = "double",
) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Statuses (N,) of NAME_monitor for thrusts (N, n) and wrenches (N, k), call by call.

    Then the thruster (N,) that NAME_suspect names behind each, and the log odds (N,). Noise lasts ``lasting``
    calls.
    """
    columns, weights = columns_by_noise(vehicle, noise), weights_by_noise(vehicle, noise)
    most, turn, lost = largest_squares(vehicle), 0, sums_rounding(vehicle, scalar)
    of = turns(vehicle.n)
    push, power, sent = np.zeros((3, vehicle.n))
    rest, calls = np.zeros((TURNS, vehicle.k)), np.zeros(TURNS)
    status, who = np.zeros((2, len(F)), dtype=np.intp)
    odds = np.zeros(len(F))
    for row, (f, wrench) in enumerate(zip(F, wrenches, strict=True)):
        r = vehicle.TP @ f - wrench
        if f @ f + r @ r <= most:
            i = of == turn
            push[i] = KEPT * push[i] + f[i] * (columns.T[i] @ r)
            power[i] = KEPT * power[i] + f[i] ** 2
            sent[i] = KEPT * sent[i] + f[i]
            rest[turn] = KEPT * rest[turn] + r
            calls[turn] = KEPT * calls[turn] + 1.0
            turn = (turn + 1) % TURNS
        else:
            status[row] = NOT_FINITE
        mean = sent / np.maximum(calls, 1.0)[of]
        sizes = weights * (np.maximum(power - sent * mean, 0.0) + lost * power)
        steady = mean * columns * rest[of].T
        moved = push - steady.sum(axis=0) - lost * (np.abs(push) + np.abs(steady).sum(axis=0))
        scores = np.maximum(moved - SLIGHT * sizes, 0.0) ** 2 / (sizes + LEAST)
        *_, second, best = np.sort(np.append(scores, 0.0))
        who[row] = int(scores.argmax()) if best > 0.0 else NOBODY
        odds[row] = (best - second) / (2 * inflation(lasting))
    return status, who, odds


def turns(count: int) -> IndexArray:
    """Turn (count,) of each of so many thrusters."""
    return np.arange(count) * TURNS // max(count, 1)


def inflation(lasting: float) -> float:
    """Variance of sums over turns of noise that lasts so many calls, over that of independent noise [-]."""
    return float(1.0 / np.tanh(0.5 * TURNS / lasting))


def sums_rounding(vehicle: Vehicle, scalar: Scalar) -> float:
    """Most that rounding changes a running sum of that scalar, relative to the sum of its sizes [-].

    Two roundings a turn, for as long as a sum remembers, and those of a . r.
    """
    unit = np.finfo(np.float32 if scalar == "float" else np.float64).eps
    return float(unit) * (MEMORY / TURNS + vehicle.k)


def columns_by_noise(vehicle: Vehicle, noise: FloatArray) -> FloatArray:
    """T_i over noise squared (k, n): a . r for a residual r in N, N m."""
    return vehicle.TP / noise[:, None] ** 2


def weights_by_noise(vehicle: Vehicle, noise: FloatArray) -> FloatArray:
    """a_i . a_i (n,) [1/N^2]."""
    weights: FloatArray = (columns_by_noise(vehicle, noise) * vehicle.TP).sum(axis=0)
    return weights


def _most(vehicle: Vehicle) -> FloatArray:
    """Most (k,) that thrusters together push on each axis [N, N m]."""
    most: FloatArray = np.abs(vehicle.TP) @ np.maximum(np.abs(vehicle.f_min), np.abs(vehicle.f_max))
    return most


def largest_squares(vehicle: Vehicle) -> float:
    """Largest f . f + r . r that is taken, in N and N m."""
    return vehicle.k * (WRENCHES * float(_most(vehicle).max(initial=vehicle.f_scale))) ** 2
