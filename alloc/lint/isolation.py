"""Failures that nobody announces: the smallest loss that shows, pairs that look alike, demands to fly.

An allocator that believes the whole vehicle asks thrusts f = T* tau of least effort (eq. 9). A thruster i
that loses the share l of its thrust leaves the residual wrench r = -l f_i T_i. A wrench is known up to noise,
independent on each axis; a_i = T_i / noise is a column in standard deviations.

Thruster i shows where l |f_i| |a_i| reaches SEPARATION. With l = 1, thruster i is told from j where the
residual is as far from any multiple of a_j: |f_i| |a_i| sin(a_i, a_j), and j from i likewise. Only the
direction of one residual counts, since the loss is not known. Both are maximised over demands within limits
by linear programs. Where columns are parallel and H is diagonal, so are rows of T*: no demand whose answer is
T* tau tells such thrusters apart.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.vehicle import Vehicle
from alloc.vehicle.geometry import unit

SEPARATION = 3.3
"""Standard deviations: the nearer of two directions is then the right one in 95 % of cases or more."""
NOISE = 0.05
"""Noise that is assumed on each axis, of the most that thrusters together push there: drag known to a fifth,
while the vehicle moves at a quarter of full thrust [-]."""
EVERY = 1.0
"""Loss of a thruster that is off [-]."""


class Shows(NamedTuple):
    """Visibility of one thruster's failure.

    Attributes
    ----------
    name : what it is called
    loss : the smallest loss that shows at some demand: 0.5 is half strength, 1 off, 2 reversed [-]
    """

    name: str
    loss: float


class Trial(NamedTuple):
    """A demand to fly that tells thrusters apart.

    Attributes
    ----------
    tau : (k,) the demand [N, N m]
    f : (n,) thrusts that the allocator believes in [N]
    pairs : names of the thrusters that it tells apart, two by two
    """

    tau: FloatArray
    f: FloatArray
    pairs: tuple[tuple[str, str], ...]


class Isolation(NamedTuple):
    """Failures of one vehicle that can be seen and told apart.

    Attributes
    ----------
    noise : (k,) of a measured or estimated wrench, one standard deviation [N, N m]
    is_stated : True if somebody stated it
    shows : of each working thruster
    alike : pairs that no demand within limits tells apart, with the separation reached [-]
    trials : demands that together tell all others apart, none larger than that takes
    """

    noise: FloatArray
    is_stated: bool
    shows: tuple[Shows, ...]
    alike: tuple[tuple[str, str, float], ...]
    trials: tuple[Trial, ...]


def assumed_noise(vehicle: Vehicle) -> FloatArray:
    """Noise (k,) of a wrench where the user states none: NOISE of what thrusters together push [N, N m]."""
    farthest = np.maximum(np.abs(vehicle.f_min), np.abs(vehicle.f_max))
    most: FloatArray = np.abs(vehicle.TP) @ farthest
    return NOISE * np.where(most > 0.0, most, vehicle.wrench_scale)


def isolation(vehicle: Vehicle, noise: FloatArray | None = None) -> Isolation:
    """Visibility of each failure, pairs that look alike, and the demands that tell the others apart."""
    is_stated, noise = noise is not None, assumed_noise(vehicle) if noise is None else noise
    strong = vehicle.strong if vehicle.weak_left.any() else vehicle
    G, on = generalized_inverse(strong), vehicle.working.tolist()
    columns = vehicle.TP / noise[:, None]
    lengths = np.linalg.norm(columns, axis=0)
    largest = {i: _largest(vehicle, G, (i,), lengths[[i]]) for i in on}
    shows = [
        Shows(vehicle.called(i), SEPARATION / size if size > 0 else np.inf)
        for i, (size, _) in largest.items()
    ]
    alike, apart = [], {}
    for i, j in combinations(on, 2):
        sine = _sine(columns[:, i], columns[:, j])
        size, f = _largest(vehicle, G, (i, j), sine * lengths[[i, j]])
        if size < SEPARATION:
            alike.append((vehicle.called(i), vehicle.called(j), size))
        else:
            apart[i, j] = (sine * lengths[[i, j]], f)
    trials = [
        Trial(strong.TP @ f, f, tuple((vehicle.called(i), vehicle.called(j)) for i, j in pairs))
        for f, pairs in _fewest(apart)
    ]
    return Isolation(noise, is_stated, tuple(shows), tuple(alike), tuple(trials))


def _sine(a: FloatArray, b: FloatArray) -> float:
    """Sine of the angle between two lines; 0 where one has no direction."""
    if not a.any() or not b.any():
        return 0.0
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    return float(np.linalg.norm(a - (a @ b) * b))


def _largest(
    vehicle: Vehicle, G: FloatArray, which: Sequence[int], weights: FloatArray
) -> tuple[float, FloatArray]:
    """Largest min_i weight_i |f_i| over thrusts f = G tau within limits, and these thrusts (n,)."""
    from scipy.optimize import linprog

    k, scale, best = vehicle.k, vehicle.f_scale, (0.0, np.zeros(vehicle.n))
    if not (weights > 0.0).all():
        return best
    on = vehicle.working
    unit_map = G * vehicle.wrench_scale / scale  # from tau in wrench_scale to f in f_scale
    within = np.pad(np.vstack([unit_map[on], -unit_map[on]]), ((0, 0), (0, 1)))
    ends = np.concatenate([vehicle.f_max[on], -vehicle.f_min[on]]) / scale
    relative = weights / weights.max()
    for signs in product((1.0, -1.0), repeat=len(which)):
        margins = -(np.array(signs) * relative)[:, None] * unit_map[list(which)]
        optimum = linprog(
            np.append(np.zeros(k), -1.0),
            A_ub=np.vstack([np.hstack([margins, np.ones((len(which), 1))]), within]),
            b_ub=np.append(np.zeros(len(which)), ends),
            bounds=[*[(None, None)] * k, (0, None)],
            # HiGHS accepts no tighter tolerances.
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if optimum.status != 0 or optimum.x is None:  # limits that leave out zero thrust
            continue
        f = np.clip(scale * unit_map @ optimum.x[:k], vehicle.f_min, vehicle.f_max)
        reached = _reached(weights, f, which)
        best = (reached, f) if reached > best[0] else best
    return best


def _fewest(
    apart: dict[tuple[int, int], tuple[FloatArray, FloatArray]],
) -> Iterator[tuple[FloatArray, list[tuple[int, int]]]]:
    """Thrusts that tell all pairs apart: the one that tells most first, drawn in to what these need."""
    left = dict.fromkeys(apart)
    while left:
        reached = [{pair: _reached(apart[pair][0], f, pair) for pair in left} for _, f in apart.values()]
        counts = [sum(size >= SEPARATION for size in each.values()) for each in reached]
        chosen = int(np.argmax(counts))
        told = {pair: size for pair, size in reached[chosen].items() if size >= SEPARATION * (1 - 1e-9)}
        drawn_in = SEPARATION / min(told.values())
        yield drawn_in * list(apart.values())[chosen][1], list(told)
        left = {pair: None for pair in left if pair not in told}


def _reached(weights: FloatArray, f: FloatArray, which: Sequence[int]) -> float:
    return float((weights * np.abs(f[list(which)])).min())


def as_text(vehicle: Vehicle, found: Isolation) -> str:
    """Lines of ``check --failures``: the noise, what shows, what looks alike, what to fly."""
    noise = ", ".join(
        f"{axis} {size:.3g} {unit(axis)}" for axis, size in zip(vehicle.dof, found.noise, strict=True)
    )
    by_default = "" if found.is_stated else f", assumed: {100 * NOISE:.0f} % of what thrusters push together"
    lines = [f"noise    {noise} (one standard deviation{by_default})"]
    lines += [f"shows    {each.name}: {_loss_words(each.loss)}" for each in found.shows]
    lines += [
        f"alike    {a} and {b}: no demand within limits tells one that is off from the other"
        f" ({size:.2g} of {SEPARATION} standard deviations)"
        for a, b, size in found.alike
    ]
    total = sum(len(trial.pairs) for trial in found.trials)
    for i, trial in enumerate(found.trials):
        asked = ", ".join(
            f"{axis} {value:+.3g} {unit(axis)}"
            for axis, value in zip(vehicle.dof, trial.tau, strict=True)
            if abs(value) > 1e-6 * np.abs(trial.tau).max()
        )
        lines.append(f"fly {i}    {asked}: {_pair_words(trial.pairs, total)}")
    return "\n".join(lines)


def _pair_words(pairs: Sequence[tuple[str, str]], total: int) -> str:
    if len(pairs) == total:
        return "tells any two others apart, if one is off"
    return f"tells {', '.join(' from '.join(pair) for pair in pairs)}, if one is off"


def _loss_words(loss: float) -> str:
    if loss > 2.0:
        return "not even reversed"
    if loss > EVERY:
        return f"not if it is off; reversed it does (a loss of {loss:.2g})"
    return f"from a loss of {100 * loss:.2g} %"
