"""The point nearest to the origin in l <= A z <= u, exactly, in a number of steps known beforehand.

Seidel's incremental algorithm (Discrete & Computational Geometry 6, 1991), with a strictly convex cost
in place of a linear one: take the slabs one by one; keep z while it lies inside; when slab i is
violated, the optimum of the first i lies on the violated side's plane, so restrict the earlier slabs to
that plane and solve there, one dimension lower. Everything but l and u depends on A alone and stands
in tables. The order is fixed, not random: m is small, and a demand then takes the same steps each time.
"""

from dataclasses import dataclass
from functools import cached_property
from math import comb, inf
from operator import mul

import numpy as np

from alloc.allocation import FloatArray
from alloc.nullspace.structure import ZERO
from alloc.vehicle import RANK_TOLERANCE

Point = list[float]


@dataclass(frozen=True, eq=False, kw_only=True)
class Slab:
    """Parallel rows of A taken together, lo <= normal'z <= hi, with the earlier slabs cut by its planes.

    Attributes
    ----------
    members : (row, scale) of each row, with A[row] = normal / scale
    slack : largest lo - hi that still counts as touching [unit of l and u]
    normal : (d,) common normal of the rows
    base : (d,) b * base is the point of the plane normal'z = b nearest to the origin
    along : (d, d - 1) orthonormal columns spanning the plane; z = b * base + along y
    shift : (i,) on the plane, earlier slab j reads lo_j - b shift_j <= (along'normal_j)'y <= hi_j - b shift_j
    plane : the earlier slabs on the plane; None for d = 1, where a plane is a point
    """

    members: tuple[tuple[int, float], ...]
    slack: float
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
    slabs : the other rows, parallel ones taken together, in their order in A
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
        """Whether each row is a slab of its own, so that lower and upper are the slabs' limits already."""
        return all(slab.members == ((row, 1.0),) for row, slab in enumerate(self.slabs)) and not self.checks

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
            for row, scale in slab.members:
                if scale > 0.0:
                    a, b = lower[row] * scale, upper[row] * scale
                else:
                    a, b = upper[row] * scale, lower[row] * scale
                if a > lo:
                    lo = a
                if b < hi:
                    hi = b
            if lo > hi:
                if lo - hi > slab.slack:
                    return None
                lo = hi = 0.5 * (lo + hi)
            los.append(lo)
            his.append(hi)
        return los, his


def steps_bound(m: int, d: int) -> int:
    """Worst-case steps of m slabs in d dimensions, no two parallel at any level of the recursion.

    W(m, 1) = m and W(m, d) = m + sum_i (1 + W(i, d - 1)), i = 0 … m - 1, which adds up to
    C(m, d) + 2 (C(m, 1) + … + C(m, d - 1)). Parallel slabs need fewer.
    """
    return comb(m, d) + 2 * sum(comb(m, j) for j in range(1, d))


def prepare(A: FloatArray, tolerance: float) -> Region:
    """Tables for l <= A z <= u, A (m, d) with d >= 1; ``tolerance`` as in Region."""
    m, d = A.shape
    sizes = np.linalg.norm(A, axis=1)
    zero = sizes <= RANK_TOLERANCE * sizes.max(initial=0.0)
    groups: list[list[tuple[int, float]]] = []
    for row in np.flatnonzero(~zero):
        for group in groups:
            leader = A[group[0][0]]
            share = float(A[row] @ leader) / float(leader @ leader)
            if np.linalg.norm(A[row] - share * leader) <= RANK_TOLERANCE * sizes[row]:
                # Rows that differ by rounding count as equal: one multiplication less, here and in C.
                equal = abs(abs(share) - 1.0) <= ZERO
                group.append((int(row), float(np.sign(share)) if equal else 1.0 / share))
                break
        else:
            groups.append([(int(row), 1.0)])
    normals = np.array([A[group[0][0]] for group in groups]).reshape(-1, d)
    slabs = tuple(_slab(tuple(group), normals[: i + 1], tolerance) for i, group in enumerate(groups))
    return Region(d=d, m=m, checks=tuple(np.flatnonzero(zero).tolist()), slabs=slabs, tolerance=tolerance)


def _slab(members: tuple[tuple[int, float], ...], normals: FloatArray, tolerance: float) -> Slab:
    earlier, normal = normals[:-1], normals[-1]
    d, square = len(normal), float(normal @ normal)
    # A Householder reflection that turns the normal onto an axis; its other columns span the plane.
    along = np.linalg.qr(normal[:, None], mode="complete").Q[:, 1:]
    return Slab(
        members=members,
        slack=tolerance * min(abs(scale) for _, scale in members),
        normal=normal.tolist(),
        base=(normal / square).tolist(),
        along=along.tolist(),
        shift=(earlier @ normal / square).tolist(),
        plane=prepare(_clean(earlier @ along, earlier), tolerance) if d > 1 else None,
    )


def _clean(restricted: FloatArray, full: FloatArray) -> FloatArray:
    # A slab parallel to the plane leaves only rounding on it, and rounding must not pass for a direction.
    left = np.linalg.norm(restricted, axis=1) > RANK_TOLERANCE * np.linalg.norm(full, axis=1)
    cleaned: FloatArray = np.where(left[:, None], restricted, 0.0)
    return cleaned
