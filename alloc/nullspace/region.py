"""The point nearest to the origin in l <= A z <= u, exactly, in a number of steps known beforehand.

Seidel's incremental algorithm (Discrete & Computational Geometry 6, 1991), with a strictly convex cost
in place of a linear one: take the slabs one by one; keep z while it lies inside; when slab i is
violated, the optimum of the first i lies on the violated side's plane, so restrict the earlier slabs to
that plane and solve there, one dimension lower. Everything but l and u depends on A alone and stands
in tables. The order is fixed, not random: m is small, and a demand then takes the same steps each time.

A row that is thin, on its plane or from the start, turns a limit that is off by rounding into a z that is off
by rounding over its length, for which all others would pay where the limits leave no room. So thin rows come
first, and where they contradict others the others have the last word: a thin row then misses by rounding.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from math import comb, inf, log
from operator import mul
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.vehicle.degeneracy import COLLINEAR, NOTHING

Point = list[float]

THIN = 0.01
"""Rows this much shorter than others are sorted before them; those alike magnify rounding by the inverse."""


class Alike(NamedTuple):
    """Parallel rows of A that are about as long.

    Attributes
    ----------
    rows : (row, scale) of each, with A[row] = normal / scale
    slack : largest lo - hi that still counts as touching [unit of l and u, of the normal]
    """

    rows: tuple[tuple[int, float], ...]
    slack: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Slab:
    """Parallel rows of A taken together, lo <= normal'z <= hi, with the earlier slabs cut by its planes.

    Attributes
    ----------
    members : the rows, the longest first
    normal : (d,) common normal of the rows
    base : (d,) b * base is the point of the plane normal'z = b nearest to the origin
    along : (d, d - 1) orthonormal columns spanning the plane; z = b * base + along y
    shift : (i,) on the plane, earlier slab j reads lo_j - b shift_j <= (along'normal_j)'y <= hi_j - b shift_j
    plane : the earlier slabs on the plane; None for d = 1, where a plane is a point
    """

    members: tuple[Alike, ...]
    normal: Point
    base: Point
    along: list[Point]
    shift: Point
    plane: "Region | None"


@dataclass(frozen=True, eq=False, kw_only=True)
class Region:
    """Tables to solve l <= A z <= u for one A (m, d).

    Attributes
    ----------
    d : dimension of z
    m : number of rows
    checks : rows of A that are zero, which hold or fail whatever z is
    slabs : the other rows, parallel ones taken together, thin ones first, else in their order in A
    tolerance : largest violation of a row that still counts as held [unit of l and u]
    """

    d: int
    m: int
    checks: tuple[int, ...]
    slabs: tuple[Slab, ...]
    tolerance: float

    @cached_property
    def worst_case_steps(self) -> int:
        """Steps that no l and u can exceed: a step is a row looked at or a slab tested."""
        if self.d == 1:
            return self.m
        return self.m + sum(1 + slab.plane.worst_case_steps for slab in self.slabs if slab.plane)

    @cached_property
    def plain(self) -> bool:
        """True if each row is a slab of its own, so that lower and upper are the slabs' limits already."""
        alone = (
            len(slab.members) == 1 and slab.members[0].rows == ((row, 1.0),)
            for row, slab in enumerate(self.slabs)
        )
        return all(alone) and not self.checks

    def nearest(self, lower: Point, upper: Point) -> tuple[Point | None, int]:
        """Shortest z (d,) with lower <= A z <= upper, None where there is none, and the steps taken."""
        steps = self.m
        limits = (lower, upper) if self.plain else self._limits(lower, upper)
        if limits is None:
            return None, steps
        los, his = limits
        if self.d == 1:
            # All rows of a one-dimensional A are parallel: clamp 0 into their common interval.
            b = 0.0
            for lo, hi, slab in zip(los, his, self.slabs, strict=True):
                b = slab.base[0] * (lo if lo > 0.0 else hi if hi < 0.0 else 0.0)
            return [b], steps
        z: Point | None = None  # stands for zero, whose products need not be taken
        for lo, hi, slab in zip(los, his, self.slabs, strict=True):
            steps += 1
            s = sum(map(mul, slab.normal, z)) if z else 0.0
            if lo <= s <= hi:
                continue
            b = lo if s < lo else hi
            assert slab.plane is not None  # d > 1
            y, below = slab.plane.nearest(
                [lo - b * c for lo, c in zip(los, slab.shift, strict=False)],
                [hi - b * c for hi, c in zip(his, slab.shift, strict=False)],
            )
            steps += below
            if y is None:
                return None, steps
            z = [b * base + sum(map(mul, row, y)) for base, row in zip(slab.base, slab.along, strict=True)]
        return z or [0.0] * self.d, steps

    def _limits(self, lower: Point, upper: Point) -> tuple[Point, Point] | None:
        """lo and hi of each slab from its rows' limits; None where no z can meet them."""
        tolerance = self.tolerance
        for row in self.checks:
            if lower[row] > tolerance or upper[row] < -tolerance:
                return None
        los: Point = []
        his: Point = []
        for slab in self.slabs:
            lo, hi = -inf, inf
            for rows, slack in slab.members:
                low, high = -inf, inf
                for row, scale in rows:
                    if scale > 0.0:
                        a, b = lower[row] * scale, upper[row] * scale
                    else:
                        a, b = upper[row] * scale, lower[row] * scale
                    if a > low:
                        low = a
                    if b < high:
                        high = b
                if low > high or low > hi or high < lo:
                    if max(low - high, low - hi, lo - high) > slack:
                        return None
                    if low > high:
                        low = high = 0.5 * (low + high)
                if lo == -inf:  # the longest rows, mostly all there are
                    lo, hi = low, high
                else:
                    lo, hi = min(max(low, lo), hi), min(max(high, lo), hi)
            los.append(lo)
            his.append(hi)
        return los, his


def steps_bound(m: int, d: int) -> int:
    """Worst-case steps of m slabs in d dimensions, no two parallel at any level of the recursion.

    W(m, 1) = m and W(m, d) = m + sum_i (1 + W(i, d - 1)), i = 0 … m - 1, which adds up to
    C(m, d) + 2 (C(m, 1) + … + C(m, d - 1)). Parallel slabs need fewer.
    """
    return comb(m, d) + 2 * sum(comb(m, j) for j in range(1, d))


def prepare(A: FloatArray, tolerance: float, thin: float = THIN) -> Region:
    """Tables for l <= A z <= u, A (m, d) with d >= 1; ``tolerance`` as in Region, ``thin`` as THIN."""
    longest = np.full(len(A), np.linalg.norm(A, axis=1).max(initial=0.0))
    return _region(A, tolerance, thin, longest, longest)


def _region(A: FloatArray, tolerance: float, thin: float, above: FloatArray, longest: FloatArray) -> Region:
    """Tables for rows whose lengths were ``above`` before a plane was taken, and ``longest`` those of all."""
    m, d = A.shape
    sizes = np.linalg.norm(A, axis=1)
    zero = sizes <= COLLINEAR * above  # such a row is parallel to the plane, and rounding is no direction
    # How thin a row is, in whole steps.
    steps = [int(log(size / most, thin)) if size else 0 for size, most in zip(sizes, longest, strict=True)]
    groups: list[list[int]] = []
    for row in np.flatnonzero(~zero).tolist():
        for group in groups:
            if np.linalg.norm(A[row] - _share(A, row, group[0]) * A[group[0]]) <= COLLINEAR * sizes[row]:
                group.append(row)
                break
        else:
            groups.append([row])
    groups = [sorted(group, key=lambda row: steps[row]) for group in groups]
    groups.sort(key=lambda group: -steps[group[0]])
    leaders = [group[0] for group in groups]
    normals = A[leaders]

    def slab(i: int) -> Slab:
        earlier, normal = normals[:i], normals[i]
        square = float(normal @ normal)
        # A Householder reflection that turns the normal onto an axis; its other columns span the plane.
        along = np.linalg.qr(normal[:, None], mode="complete").Q[:, 1:]
        rest = leaders[:i]
        return Slab(
            members=tuple(
                _alike(A, leaders[i], list(rows), tolerance)
                for _, rows in groupby(groups[i], key=lambda row: steps[row])
            ),
            normal=normal.tolist(),
            base=(normal / square).tolist(),
            along=along.tolist(),
            shift=(earlier @ normal / square).tolist(),
            plane=_region(earlier @ along, tolerance, thin, sizes[rest], longest[rest]) if d > 1 else None,
        )

    return Region(
        d=d,
        m=m,
        checks=tuple(np.flatnonzero(zero).tolist()),
        slabs=tuple(slab(i) for i in range(len(groups))),
        tolerance=tolerance,
    )


def leading(A: FloatArray) -> FloatArray:
    """The row of A (m, 1), all of whose rows are parallel, that ``prepare`` takes as their normal."""
    (slab,) = prepare(A, inf).slabs
    return np.array(slab.normal)


def _share(A: FloatArray, row: int, leader: int) -> float:
    return float(A[row] @ A[leader]) / float(A[leader] @ A[leader])


def _alike(A: FloatArray, leader: int, rows: list[int], tolerance: float) -> Alike:
    scales = []
    for row in rows:
        share = _share(A, row, leader)
        # Rows that differ by rounding count as equal: one multiplication less, here and in C.
        scales.append(float(np.sign(share)) if abs(abs(share) - 1.0) <= NOTHING else 1.0 / share)
    return Alike(tuple(zip(rows, scales, strict=True)), tolerance * min(map(abs, scales)))


def nearest_many(region: Region, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shortest z (d, N) with lower <= A z <= upper, both (m, N), and the excess (N,) over them.

    The excess is in units of what counts as touching; where it is above 1, a column has no such z.
    """
    count = lower.shape[1]
    excess = np.zeros(count)
    for row in region.checks:
        excess = np.maximum(excess, np.maximum(lower[row], -upper[row]) / region.tolerance)
    lo = np.empty((len(region.slabs), count))
    hi = np.empty_like(lo)
    for i, slab in enumerate(region.slabs):
        lo[i], hi[i] = -np.inf, np.inf
        for alike in slab.members:
            sides = [
                (lower[row] * scale, upper[row] * scale)[:: 1 if scale > 0 else -1]
                for row, scale in alike.rows
            ]
            low, high = np.max([low for low, _ in sides], axis=0), np.min([high for _, high in sides], axis=0)
            apart = np.maximum(low - high, np.maximum(low - hi[i], lo[i] - high))
            excess = np.maximum(excess, apart / alike.slack)
            touching = low > high
            low[touching] = high[touching] = 0.5 * (low[touching] + high[touching])
            lo[i], hi[i] = low.clip(lo[i], hi[i]), high.clip(lo[i], hi[i])
    z = np.zeros((region.d, count))
    for i, slab in enumerate(region.slabs):
        s = np.asarray(slab.normal) @ z
        out = np.flatnonzero((excess <= 1.0) & ((s < lo[i]) | (s > hi[i])))
        if not out.size:
            continue
        b = np.where(s[out] < lo[i, out], lo[i, out], hi[i, out])
        z[:, out] = np.multiply.outer(slab.base, b)
        if slab.plane is not None:
            moved = np.multiply.outer(slab.shift, b)
            y, beyond = nearest_many(slab.plane, lo[:i, out] - moved, hi[:i, out] - moved)
            excess[out] = np.maximum(excess[out], beyond)
            z[:, out] += np.asarray(slab.along) @ y
    return z, excess
