"""Questions to each cell before anything is timed: demands of every kind, failures, edges."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache

import numpy as np

from alloc import NotApplicable, Vehicle
from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from bench.demands import DemandSet, along_axes, build_demands, labelled
from bench.demands.generated import edge_demands, numbered
from bench.demands.store import Case
from bench.judging.question import Answers, Question, Unanswered, questions

TIMED = {"inactive": 15, "active": 15}
"""Number of timed demands of each kind. Infeasible ones are not: an iterative solver spends most of its
time on them, and a slow-down of the rest of a call would not show beside it."""

LOOKED_AT = {"inactive": 1000, "active": 3000, "boundary": 1000, "infeasible": 1000}
"""Number of demands of each kind whose answers are compared. A fault in one of a thousand, of active demands
alone, is among 3,000 of them with a probability of 1 - 0.999^3000 = 95 %; of all, with 99.8 %."""

EDGES = 500
"""The same, of demands on vertices, edges and faces of what the vehicle can do, shortened and lengthened."""

MIXED, MOVING, JOLTS = "gate", "limits of each call", 3000
"""Names of the set of all kinds, and of one whose demands come with limits of their own, and of how many."""

ALONE, ONE_SIDE = ("f_min alone", "f_max alone"), 100
"""Names of the sets in which calls give limits of one side, and how many of ``MOVING`` each has."""

FAILED = {"inactive": 20, "active": 40, "infeasible": 20}
"""The same, with each thruster off in turn: what a failure breaks, it breaks in many demands."""

WIDER = "limits wider than the vehicle's"
"""Name of a set whose limits are twice the vehicle's, which a call may give."""

RESIZED, SIZES, ONE_IN = "near rest or far out", (1e-3, 10.0, 1e3), 50
"""Name of a set of mixed demands times these, one in so many: what winds up is asked for a thousandfold."""

TWO_OFF, WEAKER = ((0, 1), (1, -1), (-2, -1)), 0.4
"""Pairs of working thrusters that are off at once, and what is left of a weaker one; asked as ``FAILED``."""

FAILED_MOVING = {"inactive": 20, "infeasible": 20}
"""The same, with a thruster off and limits of the call, or with limits wider than the vehicle's."""

AXES, FAILED_AXES = 60, 24
"""Number of demands along each axis alone beside these, of the whole vehicle and with a thruster
off, some on two axes, and none at all: they are what a vehicle is asked most, and none is drawn by chance."""

REPEATED = 50
"""One demand of so many comes twice in a row, as an autopilot's do: what a call remembers must not matter."""

NEARLY, HARD, HARD_DEMANDS = "nearly symmetric", 13, 200
"""Name of the vehicle whose edges every method is asked too, its number, and how many demands. It has eight
thrusters, each the mirror image of its neighbours but for the last digits of T. A method that stepped onto
the thin rows of such a T missed the wrench of a third of these demands."""

SEED = 2004


def demand_sets(vehicle: Vehicle) -> list[DemandSet]:
    """The demands that cells of a vehicle are asked.

    All kinds mixed; then those with limits of their own, of both sides and of one; then those with each
    thruster off in turn, with two off, and with a weaker one; near rest and far out; within wider limits.
    """
    edges = edge_demands(vehicle, np.random.default_rng(SEED), EDGES)
    mixed = np.random.default_rng(SEED).permutation(np.vstack([_of_kinds(vehicle, LOOKED_AT), edges]))
    again = np.arange(1, len(mixed), REPEATED)
    mixed[again] = mixed[again - 1]
    sizes = [size * mixed[i :: ONE_IN * len(SIZES)] for i, size in enumerate(SIZES)]
    mixed = np.vstack([along_axes(vehicle, AXES), mixed])
    moving = [replace(build_demands("jolts", vehicle, SEED, JOLTS), name=MOVING)]
    for name, *sides in ((ALONE[0], moving[0].f_min, None), (ALONE[1], None, moving[0].f_max)):
        low, high = (None if side is None else side[:ONE_SIDE] for side in sides)
        moving.append(labelled(name, vehicle, moving[0].taus[:ONE_SIDE], low, high))
    states = {i: vehicle.with_fault(i) for i in vehicle.working.tolist() if len(vehicle.working) > 1}
    failed = [_in_state(f"thruster {i} off", off) for i, off in states.items()]
    both = [_within(f"thruster {i} off, limits of each call", off, 0.5) for i, off in states.items()]
    other = labelled(RESIZED, vehicle, np.vstack(sizes))
    wider = _within(WIDER, vehicle, 2.0)
    return [labelled(MIXED, vehicle, mixed), *moving, *failed, *both, *_worse(vehicle), other, wider]


def _worse(vehicle: Vehicle) -> Iterator[DemandSet]:
    """Demands with two thrusters off, as far as others are left, and with one that is weaker."""
    working = vehicle.working.tolist()
    pairs = {tuple(sorted((working[i], working[j]))) for i, j in TWO_OFF if len(working) > 2}
    for i, j in sorted(pairs):
        with suppress(VehicleError):  # nothing else pushes
            yield _in_state(f"thrusters {i} and {j} off", vehicle.with_fault(i).with_fault(j))
    yield _in_state(f"thruster {working[0]} weaker", vehicle.with_fault(working[0], WEAKER))


def _in_state(name: str, vehicle: Vehicle) -> DemandSet:
    """Questions with certain thrusters off, or weaker."""
    return labelled(name, vehicle, np.vstack([along_axes(vehicle, FAILED_AXES), _of_kinds(vehicle, FAILED)]))


def _within(name: str, vehicle: Vehicle, share: float) -> DemandSet:
    """Demands within such a share of the limits, also of a thruster that is off, as callers give them.

    Within wider limits they are larger, some beyond what the vehicle's own would allow.
    """
    taus = max(1.0, 0.75 * share) * _of_kinds(vehicle, FAILED_MOVING)
    low, high = (np.tile(share * side, (len(taus), 1)) for side in _limits_of_all(vehicle))
    return replace(labelled(name, vehicle, taus, low, high), f_min=low, f_max=high)


def _limits_of_all(vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    """f_min and f_max (n,) of the vehicle, and its largest limit for a thruster that is off [N]."""
    off = vehicle.readiness == 0
    return np.where(off, -vehicle.f_scale, vehicle.f_min), np.where(off, vehicle.f_scale, vehicle.f_max)


def timed_demands(vehicle: Vehicle) -> FloatArray:
    """The demands (N, k) that a vehicle's cells are timed with [N, N m]."""
    return _of_kinds(vehicle, TIMED)


@cache
def nearly_symmetric() -> Question:
    """Demands on the edges of a nearly symmetric vehicle, which is no cell's; judged by equations alone."""
    vehicle, rng = numbered(HARD)
    taus = edge_demands(vehicle, rng, HARD_DEMANDS)
    return questions([labelled(NEARLY, vehicle, taus)], nobody)[0]


def _of_kinds(vehicle: Vehicle, kinds: Mapping[str, int]) -> FloatArray:
    sets = []
    for kind, n in kinds.items():
        try:
            sets.append(build_demands(kind, vehicle, SEED, n).taus)
        except NotApplicable:  # without redundancy no demand is active
            continue
    return np.concatenate(sets)


def nobody(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
    """An ``Ask`` that answers nothing, where answers are judged by equations alone."""
    return [Unanswered("missing", "nobody is trusted with an optimum")] * len(cases)
