"""Way from thrusts at rest towards a demand, level by level: steps, and how far each may go."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.errors import NotApplicable
from alloc.reach.attainable import FACETS
from alloc.reach.edge import INSET, edge, share, shares, slack_table, start
from alloc.reach.zonotope import candidates, zonotope
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.azimuth import rest_thrusts
from alloc.vehicle.degeneracy import NOTHING

Levels = Sequence[Sequence[str]]
"""Axes, in levels; each axis of the vehicle stands in one of them."""

KEEP = 0.99
"""A level that others follow stops at this share of the way to the edge of the attainable set. On the very
edge what is left for later levels would jump between all and nothing with the last bit of a demand."""

OWN = 0.3
"""A direction belongs to a level where more than this share of its length lies on the level's axes. Then no
step moves other axes more than sqrt(1/OWN^2 - 1) = 3.2 times as far as its own, and none the axes of an
earlier level by more than OWN of its length. Below 1/sqrt(6) each direction belongs to one of at most six
levels. With one or two thrusters off and levels as their files have them, what arms of centimetres couple
lies at 0.05 or below, what shipped vehicles couple besides at 0.39 or above."""


def step_maps(vehicle: Vehicle, levels: Levels, *, together: bool = False) -> FloatArray:
    """(L, k, k) matrices D: the step of a level from a wrench w is Delta = D (tau - w).

    Where the thrusters push every direction, D picks the level's axes, and the others stay. Where they don't,
    each direction that they push belongs to one level, the first on whose axes more than OWN of it lies, and
    Delta is the step in the level's own directions that brings its axes nearest to tau (axes in unit of
    ``row_lengths``). Later levels take nothing of that back, and all together reach each tau that can be
    pushed. With B an orthonormal basis of what the thrusters push, N one of the directions that earlier
    levels leave, S the rows of the level, and S B N = U diag(sigma) V' without the sigma up to OWN, that is
    D = B N V diag(1 / sigma) U' S. ``together`` gives all steps from the start: each as if those before it
    had gone all their way.
    """
    maps = _maps_in_turn(vehicle, levels)
    left = np.eye(vehicle.k)
    for D in maps if together else ():
        D[:] = D @ left
        left = left - D
    return maps


def _maps_in_turn(vehicle: Vehicle, levels: Levels) -> FloatArray:
    axes = [[vehicle.dof.index(axis) for axis in level] for level in levels]
    maps = np.zeros((len(axes), vehicle.k, vehicle.k))
    if vehicle.rank == vehicle.k:
        for D, rows in zip(maps, axes, strict=True):
            D[rows, rows] = 1.0
        return maps
    unit = vehicle.row_lengths
    free = np.linalg.svd(vehicle.TP / unit[:, None])[0][:, : vehicle.rank]
    for D, rows in zip(maps, axes, strict=True):
        U, sigma, Vt = np.linalg.svd(free[rows])
        r = np.count_nonzero(sigma > OWN)
        D[:, rows] = free @ (Vt[:r].T / sigma[:r]) @ U[:, :r].T
        free = free @ Vt[r:].T
    maps[np.abs(maps) <= RANK_TOLERANCE] = 0.0
    return maps * (unit[:, None] / unit)


def keeps(vehicle: Vehicle, levels: Levels, keep: float = KEEP) -> list[float]:
    """Share of its way to the edge taken by each level: all of it where no later level shares a thruster."""
    parts = [{*part} for part in groups(vehicle, vehicle.T)]
    reached = [{i for i, part in enumerate(parts) if part & {*level}} for level in levels]
    return [keep if any(own & later for later in reached[j + 1 :]) else 1.0 for j, own in enumerate(reached)]


def pushes(vehicle: Vehicle, T: FloatArray, least: float) -> BoolArray:
    """(k, n) which thrusters push which axis, by more than ``least`` of the length of its row of T [-]."""
    return np.abs(T) > least * vehicle.row_lengths[:, None]


def groups(
    vehicle: Vehicle, T: FloatArray | None = None, least: float = RANK_TOLERANCE
) -> tuple[tuple[str, ...], ...]:
    """The axes in groups that share no thruster, in the order of ``vehicle.dof``.

    The attainable set is the product of those of the groups, so no group's demand takes from another's. ``T``
    is the vehicle's with its faults, unless another is given; a thruster that pushes an axis by no more than
    ``least`` is not shared.
    """
    moved = pushes(vehicle, vehicle.TP if T is None else T, least)
    linked = (moved @ moved.T) | np.eye(vehicle.k, dtype=bool)
    connected = np.linalg.matrix_power(linked, vehicle.k)
    names = (tuple(vehicle.dof[i] for i in np.flatnonzero(row)) for row in connected)
    return tuple(dict.fromkeys(names))


def separations(vehicle: Vehicle) -> list[tuple[float, tuple[tuple[str, ...], ...]]]:
    """The axes in ``groups`` that are coupled by more than a survey's error, each with its w [-].

    Entries of T that count in part (``Vehicle.entry_counts``) couple axes by so much: the first groups are
    those that they leave apart, and behind it come coarser ones with the share w to which their axes are one
    group, the largest w first. On most vehicles there are the first alone.
    """
    counts, found = vehicle.entry_counts, [(1.0, groups(vehicle, _coupling(vehicle, 1.0)))]
    for w in sorted({*counts[(counts > 0.0) & (counts < 1.0)].tolist()}, reverse=True):
        coarser = groups(vehicle, _coupling(vehicle, w))
        if len(coarser) < len(found[-1][1]):
            found.append((w, coarser))
    return found


def _coupling(vehicle: Vehicle, least: float) -> FloatArray:
    """T (k, n) without the entries that count by less."""
    return np.where(vehicle.entry_counts >= least, vehicle.T, 0.0)


CHUNK = 4096
"""Demands that are taken together: arrays of a few megabytes stay in a processor's cache."""


class Departure(NamedTuple):
    """Start of a way, for one call or N.

    Attributes
    ----------
    wrench : w = T P f0 (…, k) [N, N m]
    slack : (…, 2M) how far the set reaches from w along each facet's normal and its opposite, at least 0
    size : (…,) that of the terms which make w: max(1, largest |f0| in unit of ``f_scale``) [-]
    """

    wrench: FloatArray
    slack: FloatArray
    size: FloatArray


def at_rest(vehicle: Vehicle) -> FloatArray:
    """Thrusts (n,) at rest where thrusters turn: 0, or a little inside of what leaves 0 out [N]."""
    return rest_thrusts(vehicle.turning, start(vehicle.f_min, vehicle.f_max), INSET)


def polygon_edge(vehicle: Vehicle) -> tuple[FloatArray, Departure]:
    """(M, k) outward normals of the set of thrusters that turn, in scaled wrench, and the start within it.

    Raises NotApplicable for more than FACETS candidates.
    """
    if candidates(vehicle) > FACETS:
        raise NotApplicable(
            f"{vehicle.name}: polygons may span more than {FACETS} facets; give them fewer sides, or"
            " take a method that needs none, as qp/daqp"
        )
    found = zonotope(vehicle)
    proper = found.tolerance <= NOTHING  # the others span what no thruster pushes
    none = (found.support >= 0.0).all()  # no wrench is attainable, also with forces that can't be zero
    w = np.zeros(vehicle.k) if none else vehicle.TP.dot(at_rest(vehicle))
    slack = np.maximum(found.support - found.facets @ (w / found.scale), 0.0)[proper]
    return found.facets[proper], Departure(w, slack, np.ones(()))


class Way:
    """The way of one vehicle through given levels: from w = T P f0 towards a demand.

    Attributes
    ----------
    levels : the axes of each level
    keep : of each level, the share of the way to the edge that it may take
    together : True if all levels start at once: each goes as far as it could alone, and then all of them are
        shortened by one factor until they fit
    goes_straight : True if no level stops before the edge
    direct : True if every attainable demand is reached: no direction is lost, and no level stops early
    """

    def __init__(
        self, vehicle: Vehicle, levels: Levels, keep: Sequence[float], *, together: bool = False
    ) -> None:
        """Prepare facets and steps; raises NotApplicable for a vehicle with too many facets."""
        self.levels, self.together = tuple(map(tuple, levels)), together
        self.keep = tuple(keep)
        self._scale, self._only = vehicle.wrench_scale, None
        if vehicle.azimuths:
            self._outward, self._only = polygon_edge(vehicle)
        else:
            found = edge(vehicle)
            half = found.normals * found.scale
            self._outward = np.vstack([half, -half])
            self._slack_of = slack_table(found.push)
        self._TP, self._f_scale = vehicle.TP, vehicle.f_scale
        self._rest, self._size = np.zeros(vehicle.k), np.ones(())
        maps = step_maps(vehicle, levels, together=together)
        self._maps = maps * (self._scale / self._scale[:, None])
        self._unstopped, self._whole = self._if_nothing_stops()
        self._straight = vehicle.rank == vehicle.k
        self.goes_straight = min(self.keep) == 1.0 and not together
        self.direct = self._straight and self.goes_straight and self._only is None

    def departure(self, f_min: FloatArray, f_max: FloatArray) -> Departure:
        """Start of the way within limits (n,), or (N, n) of N calls [N]; where thrusters turn, their own."""
        if self._only is not None:
            return self._only
        if f_min.ndim == 1 and max(f_min.tolist()) <= 0.0 <= min(f_max.tolist()):  # the usual case, quickly
            return Departure(self._rest, self._slack_of.dot(np.concatenate((f_max, -f_min))), self._size)
        f0 = start(f_min, f_max)
        widths = np.concatenate((f_max - f0, f0 - f_min), axis=-1)
        size = np.maximum(1.0, np.abs(f0).max(axis=-1) / self._f_scale)
        return Departure(f0 @ self._TP.T, widths @ self._slack_of.T, size)

    def towards(self, tau: FloatArray, begin: Departure) -> tuple[FloatArray, tuple[float, ...]]:
        """The wrench reached (k,) on the way to ``tau`` (k,) [N, N m], and the share of each level."""
        w, slack, size = begin
        missing = (tau - w) / self._scale
        if (self._unstopped.dot(missing) <= slack).all():
            end = tau if self._straight else w + self._whole.dot(missing) * self._scale
            return end, (1.0,) * len(self.keep)
        if self.together:
            ends, each = self._together(missing[None], begin)
            return ends[0], tuple(each[0].tolist())
        taken = []
        moved = 0.0 * missing
        for D, keep in zip(self._maps, self.keep, strict=True):
            step = D.dot(missing)
            along = self._outward.dot(step)
            s = share(along, slack, max(map(abs, step.tolist())), float(size), keep)
            taken.append(s)
            moved += s * step
            if len(taken) < len(self.keep):
                missing = missing - s * step
                slack = np.maximum(slack - s * along, 0.0)
        return w + moved * self._scale, tuple(taken)

    def pushed(self, tau: FloatArray) -> FloatArray:
        """The part of a wrench (k,) that thrusters push: the end of a way from 0 that nothing stops."""
        if self._straight:
            return tau
        part: FloatArray = self._whole.dot(tau / self._scale) * self._scale
        return part

    def towards_many(self, taus: FloatArray, begin: Departure) -> tuple[FloatArray, FloatArray]:
        """``towards`` for N demands (N, k): the wrenches reached (N, k), and the shares (N, L).

        ``begin`` is one for all demands, or has a row for each.
        """
        ends, taken = np.empty(taus.shape), np.empty((len(taus), len(self.keep)))
        for i in range(0, len(taus), CHUNK):
            chunk = slice(i, i + CHUNK)
            w, slack, size = begin if begin.slack.ndim == 1 else (each[chunk] for each in begin)
            missing = (taus[chunk] - w) / self._scale
            if self.together:
                ends[chunk], taken[chunk] = self._together(missing, Departure(w, slack, size))
                continue
            moved = np.zeros_like(missing)
            for j, (D, keep) in enumerate(zip(self._maps, self.keep, strict=True)):
                step = missing @ D.T
                along = step @ self._outward.T
                s = shares(along, slack, np.abs(step).max(axis=1), size, keep)[:, None]
                taken[chunk, j] = s[:, 0]
                moved += s * step
                missing -= s * step
                slack = np.maximum(slack - s * along, 0.0)
            ends[chunk] = w + moved * self._scale
        return ends, taken

    def _together(self, missing: FloatArray, begin: Departure) -> tuple[FloatArray, FloatArray]:
        """Ends (N, k) [N, N m] and shares (N, L) of levels that start at once; ``missing`` is (N, k) [-]."""
        w, slack, size = begin
        moved, along, taken = np.zeros_like(missing), np.zeros(()), []
        for D in self._maps:
            step = missing @ D.T
            own = step @ self._outward.T
            s = shares(own, slack, np.abs(step).max(axis=1), size, 1.0)[:, None]
            taken.append(s)
            moved += s * step
            along = along + s * own
        s = shares(along, slack, np.abs(moved).max(axis=1), size, 1.0)[:, None]
        return w + s * moved * self._scale, s * np.hstack(taken)

    def delivered(self, taus: FloatArray, begin: Departure, taken: FloatArray) -> FloatArray:
        """Wrenches (N, k) that shares ``taken`` (N, L) of the levels deliver of demands (N, k) [N, N m]."""
        missing = (taus - begin.wrench) / self._scale
        moved = np.zeros_like(missing)
        for D, s in zip(self._maps, taken.T, strict=True):
            step = s[:, None] * (missing @ D.T)
            moved += step
            if not self.together:
                missing -= step
        return begin.wrench + moved * self._scale

    def _if_nothing_stops(self) -> tuple[FloatArray, FloatArray]:
        """Tables for a demand that nothing stops, so that one product tells.

        With d what is missing at the departure, all shares are 1 where the first table, (L, 2M, k) or where
        levels start at once (L + 1, 2M, k), times d is at most the slack; the second, (k, k), times d is the
        way to where the last level ends.
        """
        if self.together:
            whole = self._maps.sum(axis=0)
            return self._outward @ np.concatenate((self._maps, whole[None])), whole
        left, before = np.eye(len(self._scale)), np.zeros_like(self._outward)
        tables = []
        for D, keep in zip(self._maps, self.keep, strict=True):
            along = self._outward @ D @ left
            tables.append(before + along / keep)
            before = before + along
            left = left - D @ left
        return np.array(tables), np.eye(len(left)) - left
