"""Methods asked within limits that jump: ``python docs/studies/moving_limits.py [VEHICLES]``.

Random vehicles with all that a file may hold (``odd_vehicles``, weights at most a hundred apart) are asked
demands whose limits have no width, cross, are one-sided or exclude zero. Verdicts are held to the facets,
which no method uses to find thrusts, and exact answers to those of two active-set solvers. The study prints
a table of docs/limits.md, and ends with 1 where an answer breaks a limit or says what is not so.
"""

import sys
import warnings
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alloc import AllocError, Label, NotApplicable, Status, Vehicle, build, catalogue, label
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.discovery import Entry
from alloc.formulations import Family
from bench.demands.odd_vehicles import odd_vehicle, weighted
from bench.results.text import table, three

VEHICLES, DEMANDS = 200, 100
BAND = 1e-6
"""Verdicts are compared where |alpha* - 1| is more than this: nearer, solvers' tolerances decide."""
DECADES = 2.0
"""Weights in practice differ by tens; ``docs/studies/weights.py`` is about more."""
GAVE_UP = (Status.INFEASIBLE, Status.NOT_CONVERGED)


class Jolted(NamedTuple):
    """Demands within limits of their own, and what is known of them.

    Attributes
    ----------
    vehicle : that is asked
    taus, low, high : (N, k) demands and (N, n) limits
    kind : (N,) values of ``alloc.Label``
    best : (N, n) the optimum where two solvers agree on it, else NaN
    """

    vehicle: Vehicle
    taus: FloatArray
    low: FloatArray
    high: FloatArray
    kind: NDArray[np.int8]
    best: FloatArray


def limits(vehicle: Vehicle, rng: np.random.Generator, n: int) -> tuple[FloatArray, FloatArray]:
    """Limits (n, thrusters) [N] of every kind, 0 for a thruster that is off."""
    ends = rng.uniform(-1, 1, (2, n, vehicle.n)) * vehicle.f_scale
    low, high = ends.min(axis=0), ends.max(axis=0)
    kind = rng.random(low.shape)
    low = np.where(kind < 0.2, np.minimum(0.0, high), low)
    low = np.where(kind > 0.9, high, low)
    high = np.where((kind > 0.3) & (kind < 0.32), low - 0.1 * vehicle.f_scale, high)
    off = vehicle.readiness == 0
    return np.where(off, 0.0, low), np.where(off, 0.0, high)


def asked(rng: np.random.Generator, vehicles: int, demands: int) -> Iterator[Jolted]:
    """What each of the vehicles is asked."""
    for _ in range(vehicles):
        plain = odd_vehicle(rng)
        vehicle = weighted(plain, rng, float(rng.uniform(0, DECADES)), full=bool(rng.integers(2)))
        low, high = limits(vehicle, rng, demands)
        thrusts = np.clip(rng.uniform(low, np.maximum(low, high)), low, high)
        taus = rng.choice([0.3, 0.9, 1.0, 1.3], (demands, 1)) * thrusts @ vehicle.TP.T
        kind = label(vehicle, taus, BAND, low, high).label
        one, other = (build(name, vehicle).many(taus, low, high)[0] for name in ("qp/daqp", "qp/quadprog"))
        agreed = np.abs(one - other).max(axis=1) <= 1e-9 * vehicle.f_scale
        yield Jolted(vehicle, taus, low, high, kind, np.where(agreed[:, None], one, np.nan))


def count(entry: Entry, case: Jolted, said: Counter[str]) -> float:
    """Add to ``said`` what is wrong with a method's answers; the largest distance of exact ones."""
    vehicle, taus, low, high, kind, best = case
    try:
        F, status = build(entry.name, vehicle).many(taus, low, high)
    except NotApplicable:
        said["refused"] += len(taus)
        return 0.0
    answered: BoolArray = np.logical_and.reduce(np.isfinite(F), axis=1)
    said["answers"] += len(taus)
    said["not converged"] += int((status == Status.NOT_CONVERGED).sum())
    outside: FloatArray = np.maximum(low - F, F - high).max(axis=1)
    said["broken limits"] += int((outside[answered] > 0).sum())
    said["NaN"] += int((answered == np.isin(status, GAVE_UP)).sum())
    sure: BoolArray = np.not_equal(kind, Label.BOUNDARY)
    missed: FloatArray = (
        np.abs(np.where(answered[:, None], F, 0.0) @ vehicle.TP.T - taus) / vehicle.wrench_scale
    )
    met: BoolArray = np.array(missed.max(axis=1) <= WRENCH_TOLERANCE)
    solved = np.flatnonzero(np.equal(status, Status.SOLVED))
    said["false SOLVED"] += int((~met[solved]).sum())
    said["false INFEASIBLE"] += int(
        (sure & np.equal(status, Status.INFEASIBLE) & np.not_equal(kind, Label.INFEASIBLE)).sum()
    )
    distance: FloatArray = np.abs(F - best).max(axis=1) / vehicle.f_scale
    if entry.formulation not in ("hard", "scaled"):
        return 0.0
    return float(np.nan_to_num(distance[solved]).max(initial=0.0))


def main(arguments: list[str]) -> int:
    """Print a line for each method; 1 where an answer is wrong."""
    vehicles = int(arguments[0]) if arguments else VEHICLES
    entries = [
        e for e in catalogue() if not e.missing and e.family not in (Family.ONE_SHOT, Family.CLOSED_FORM)
    ]
    said: dict[str, Counter[str]] = {entry.name: Counter() for entry in entries}
    distance = dict.fromkeys(said, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for case in asked(np.random.default_rng(11), vehicles, DEMANDS):
            for entry in entries:
                try:
                    far = count(entry, case, said[entry.name])
                except AllocError as error:
                    print(f"{entry.name}: {type(error).__name__}: {error}")
                    said[entry.name]["raised"] += 1
                    continue
                distance[entry.name] = max(distance[entry.name], far)
    wrong = ("broken limits", "NaN", "false SOLVED", "false INFEASIBLE", "raised")
    columns = ("answers", *wrong, "not converged")
    rows = [
        (name, *(str(counts[column]) for column in columns), three(distance[name]) if distance[name] else "")
        for name, counts in said.items()
    ]
    print(table(("method", *columns, "farthest from the optimum"), rows))
    return int(any(counts[what] for counts in said.values() for what in wrong))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
