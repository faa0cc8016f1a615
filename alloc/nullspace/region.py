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
from math import comb, inf, log, nan
from operator import mul
from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.vehicle.degeneracy import COLLINEAR, NOTHING, RANK_TOLERANCE

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
        """Shortest z (d,) with lower <= A z <= upper, None where there is none, and the steps taken.

        The same steps as ``nearest_many``, in floats: one call takes a twentieth of the time.
        """
        steps = self.m
        if (limits := (lower, upper) if self.plain else self._limits(lower, upper)) is None:
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

    def limits_many(
        self, lower: FloatArray, upper: FloatArray, which: IndexArray | None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """lo and hi (slabs, N) from limits (m, N) of rows, and the excess (N,) over them."""
        excess = np.zeros(lower.shape[1])
        for row in self.checks:
            excess = np.maximum(excess, np.maximum(lower[row], -upper[row]) / self.tolerance)
        lo = np.full((len(self.slabs), len(excess)), -inf)
        hi = -lo
        for i, slab in enumerate(self.slabs):
            for alike in slab.members:
                sides = [
                    (lower[row] * scale, upper[row] * scale)[:: 1 if scale > 0 else -1]
                    for row, scale in alike.rows
                ]
                low = np.max([low for low, _ in sides], axis=0)
                high = np.min([high for _, high in sides], axis=0)
                apart = np.maximum(low - high, np.maximum(low - hi[i], lo[i] - high))
                excess = np.maximum(excess, apart / alike.slack)
                touching = low > high
                low[touching] = high[touching] = 0.5 * (low[touching] + high[touching])
                lo[i], hi[i] = low.clip(lo[i], hi[i]), high.clip(lo[i], hi[i])
        return lo, hi, excess

    def normal(self, i: int) -> FloatArray:
        """(1, d) normal of a slab."""
        return np.array(self.slabs[i].normal)[None]

    def plane(self, i: int) -> "SlabPlane":
        """Plane of a slab, for many calls."""
        slab = self.slabs[i]
        assert slab.plane is not None  # d > 1
        return SlabPlane(np.array(slab.base), np.array(slab.shift), np.array(slab.along), slab.plane)

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

    checks, slabs = tuple(np.flatnonzero(zero).tolist()), tuple(map(slab, range(len(groups))))
    return Region(d=d, m=m, checks=checks, slabs=slabs, tolerance=tolerance)


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


class SlabPlane(NamedTuple):
    """A slab's plane as in ``Slab``, for many calls; of many matrices A the last axis counts those."""

    base: FloatArray
    shift: FloatArray
    along: FloatArray
    plane: "Region | Regions"


@dataclass(frozen=True, eq=False)
class Regions:
    """Tables to solve l <= A z <= u for B matrices A (m, d, B), each row of them a slab of its own.

    A row that is parallel to a plane is zero there, and holds or fails. ``slack`` (B,) is the largest excess
    over a limit that counts as met [unit of l and u].
    """

    A: FloatArray
    slack: FloatArray

    @property
    def d(self) -> int:
        """Dimension of z."""
        return int(self.A.shape[1])

    @cached_property
    def sizes(self) -> FloatArray:
        """(m, B) lengths of the rows."""
        return np.asarray(np.sqrt((self.A**2).sum(axis=1)))

    @cached_property
    def flat(self) -> BoolArray:
        """Mask (m, B) of rows that are zero."""
        return np.asarray(self.sizes <= RANK_TOLERANCE * self.sizes.max(axis=0, initial=0.0))

    def limits_many(
        self, lower: FloatArray, upper: FloatArray, which: IndexArray | None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """lo and hi (slabs, N) of calls, each to the matrix ``which`` (N,), and the excess (N,) over them."""
        assert which is not None
        excess = np.zeros(len(which))
        for row in np.flatnonzero(self.flat.any(axis=1)):
            beyond = np.maximum(lower[row], -upper[row]) / self.slack[which]
            excess = np.maximum(excess, np.where(self.flat[row, which], beyond, 0.0))
        if self.d != 1:
            free = self.flat.take(which, axis=1) if self.flat.any() else None
            ends = (
                (lower, upper) if free is None else (np.where(free, -inf, lower), np.where(free, inf, upper))
            )
            return *ends, excess
        # In one dimension all rows are parallel; fmin and fmax pass over NaN, which a row of zeros leaves.
        rate = np.where(self.flat, nan, 1.0 / np.where(self.flat, 1.0, self.A[:, 0]))
        lo, hi = np.full(len(which), -inf), np.full(len(which), inf)
        for scales, low, high in zip(rate, lower, upper, strict=True):
            scale = scales[which]
            a, b = low * scale, high * scale
            np.fmax(lo, np.minimum(a, b), out=lo)
            np.fmin(hi, np.maximum(a, b), out=hi)
        room = self.slack * np.nan_to_num(np.abs(rate)).max(axis=0, initial=1e-100)
        apart = (lo - hi) * (1.0 / room)[which]
        return lo[None], hi[None], np.maximum(excess, apart) if self.flat.any() else apart

    def normal(self, i: int) -> FloatArray:
        """(1, d, B) the row itself."""
        return self.A[i : i + 1]

    def plane(self, i: int) -> SlabPlane:
        """Plane of a row: a Householder reflection turns the row onto an axis; its other columns span it."""
        size = np.where(self.flat[i], 1.0, self.sizes[i])
        base, mirror = self.A[i] / size**2, self.A[i] / size
        mirror[0] += np.where(mirror[0] < 0, -1.0, 1.0)
        square = np.maximum((mirror**2).sum(axis=0), 1.0)
        turned = np.eye(self.d)[..., None] - (2.0 / square) * mirror[:, None] * mirror[None]
        shift = np.einsum("jdb,db->jb", self.A[:i], base)
        inside = np.einsum("jdb,deb->jeb", self.A[:i], turned[:, 1:])
        parallel = np.sqrt((inside**2).sum(axis=1)) <= RANK_TOLERANCE * self.sizes[:i]
        inside[np.broadcast_to(parallel[:, None], inside.shape)] = 0.0
        return SlabPlane(base, shift, turned[:, 1:], Regions(inside, self.slack))


def nearest_many(
    region: Region | Regions, lower: FloatArray, upper: FloatArray, which: IndexArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Shortest z (d, N) with lower <= A z <= upper, both (m, N), and the excess (N,) over them.

    The excess is in units of what counts as touching; above 1 a call has no such z. ``which`` (N,) is the
    matrix of each call, of many.
    """
    lo, hi, excess = region.limits_many(lower, upper, which)
    z = np.zeros((region.d, lower.shape[1]))
    if region.d == 1 and len(lo):
        np.minimum(np.maximum(0.0, lo), hi, out=z)
        return (z if isinstance(region, Regions) else region.slabs[0].base[0] * z), excess
    moved = False
    for i in range(len(lo)):
        s = _times(region.normal(i), z, which)[0] if moved else np.zeros(())
        below = s < lo[i]
        out = np.flatnonzero((excess <= 1.0) & (below | (s > hi[i])))
        if not out.size:
            continue
        plane, of = region.plane(i), None if which is None else which[out]
        b = np.where(below[out], lo[i, out], hi[i, out])
        by = _each(plane.shift, of) * b
        y, beyond = nearest_many(plane.plane, lo[:i, out] - by, hi[:i, out] - by, of)
        excess[out] = np.maximum(excess[out], beyond)
        z[:, out] = _each(plane.base, of) * b + _times(plane.along, y, of)
        moved = True
    return z, excess


def _each(matrix: FloatArray, which: IndexArray | None) -> FloatArray:
    """A matrix (…, 1) of all calls, or (…, N) of each call out of B matrices (…, B)."""
    return matrix[..., None] if which is None else matrix.take(which, axis=-1)


def _times(matrix: FloatArray, v: FloatArray, which: IndexArray | None) -> FloatArray:
    """Products (r, N) of a matrix (r, q), or of B (r, q, B), with v (q, N)."""
    found: FloatArray = matrix @ v if which is None else (_each(matrix, which) * v).sum(axis=-2)
    return found
