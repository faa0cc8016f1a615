"""Space of a study's layouts: parameters, the thrusters that they move, T of many at once."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.vehicle.frame import Frame
from alloc.vehicle.geometry import DOF, MOMENTS
from bench.layouts.spaces import Layouts
from bench.layouts.study import Constraints


@dataclass(frozen=True)
class Parameter:
    """Something that varies.

    Attributes
    ----------
    name : its column, ``group.key``
    low, high : the ends of a span
    choices : the values of a list; empty for a span
    steps : values that a grid takes of a span
    """

    name: str
    low: float = 0.0
    high: float = 0.0
    choices: tuple[float, ...] = ()
    steps: int = 0

    def at(self, share: FloatArray) -> FloatArray:
        """The values at shares of the way, 0 to 1, each value of a list over an equal part of it."""
        if self.choices:
            place = np.minimum((share * len(self.choices)).astype(int), len(self.choices) - 1)
            chosen: FloatArray = np.array(self.choices, dtype=float)[place]
            return chosen
        return self.low + (self.high - self.low) * share

    def share(self, values: FloatArray) -> FloatArray:
        """Shares of the way at which ``at`` gives these values."""
        if self.choices:
            place = np.argmin(np.abs(values[:, None] - np.array(self.choices)), axis=1)
            middle: FloatArray = (place + 0.5) / len(self.choices)
            return middle
        return (values - self.low) / (self.high - self.low)

    @property
    def grid(self) -> FloatArray:
        """The values that a grid takes."""
        return np.array(self.choices) if self.choices else np.linspace(self.low, self.high, self.steps)


Setting = float | Parameter
"""A number that stays, or a parameter."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Moving:
    """A group of thrusters that move together.

    Attributes
    ----------
    images : for each count that the group may have, the (count, 3, 3) matrices that turn or mirror the leader
    polarity : (count,) for each, -1 where positive thrust pushes against the image of the leader's direction
    pose : x, y, z [m], azimuth_deg, cant_deg [deg]
    size : factor on the limits
    present, count : whether the group is there, and how many thrusters it has
    f_min, f_max, weights : of each thruster, as many as the largest count [N, N, 1/N^2]
    members : numbers of the base's thrusters in it, empty for new ones
    called : their names, empty for new ones and for a base that names none
    """

    name: str
    members: tuple[int, ...] = ()
    called: tuple[str, ...] = ()
    images: dict[int, FloatArray]
    polarity: dict[int, FloatArray]
    pose: tuple[Setting, Setting, Setting, Setting, Setting]
    size: Setting
    present: Setting
    count: Setting
    f_min: tuple[float, ...]
    f_max: tuple[float, ...]
    weights: tuple[float, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class LayoutSpace:
    """All that a study's layouts are made of, as plain numbers that travel to workers.

    Attributes
    ----------
    name : of the base
    dof : degrees of freedom that count
    parameters : what varies, group by group in the order of the file
    groups : the thrusters that vary, and each other thruster as a group that does not
    center : of mass [m]
    constraints : what layouts must keep to
    taus : (N, k) the demands that they are asked [N, N m]
    reference_length : arm at which a moment counts as a force, in every direction [m]
    volume : of the base's attainable set [N^k, in the unit of T's moment arms]
    frame : frd or flu, of the base and so of every layout and demand
    left_out : keys of the base's file that layouts do not have
    notes : how the log of the demands was understood, and what is doubtful about it, one line each
    rate_hz : of the demands, None where they are no sequence in time
    """

    name: str
    dof: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    groups: tuple[Moving, ...]
    center: tuple[Setting, Setting, Setting]
    constraints: Constraints
    taus: FloatArray
    reference_length: float
    volume: float
    frame: Frame = "frd"
    left_out: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    rate_hz: float | None = None

    @property
    def scale(self) -> FloatArray:
        """(k,) divisors that turn a wrench into newtons: 1 on force axes, the reference length on moments."""
        return np.array([self.reference_length if axis in MOMENTS else 1.0 for axis in self.dof])

    def values(self, setting: Setting, values: FloatArray) -> FloatArray:
        """(B,) what a setting is in each layout; ``values`` (P, B) are the parameters'."""
        if isinstance(setting, Parameter):
            taken: FloatArray = values[self.parameters.index(setting)]
            return taken
        return np.full(values.shape[1], float(setting))


@dataclass(frozen=True, eq=False, kw_only=True)
class PlacedThrusters:
    """Thrusters of B layouts that have equally many.

    Attributes
    ----------
    which : (B,) the layouts' places among those that were asked for
    position, direction : (n, 3, B) [m], [-]; thrusters in the base's order, new ones last
    center : (3, B) of mass [m]
    f_min, f_max, weights : (n, B) [N, N, 1/N^2]
    """

    which: IndexArray
    position: FloatArray
    direction: FloatArray
    center: FloatArray
    f_min: FloatArray
    f_max: FloatArray
    weights: FloatArray

    def layouts(self, dof: tuple[str, ...]) -> Layouts:
        """T of each: columns [e; (r - r_cg) x e] (Fossen 2021, section 11.2), in the rows of ``dof``."""
        moments = np.cross(self.position - self.center, self.direction, axis=1)
        rows = np.concatenate([self.direction, moments], axis=1).swapaxes(0, 1)
        T = np.ascontiguousarray(rows[[DOF.index(axis) for axis in dof]])
        return Layouts(T=T, weights=self.weights, f_min=self.f_min, f_max=self.f_max)


def thruster_counts(space: LayoutSpace, values: FloatArray) -> list[IndexArray]:
    """(B,) how many thrusters each group has in layouts with parameters ``values`` (P, B)."""
    return [
        np.where(space.values(group.present, values) > 0, space.values(group.count, values), 0).astype(int)
        for group in space.groups
    ]


def base_order(groups: tuple[Moving, ...], counts: Sequence[int]) -> IndexArray:
    """(n,) places, among thrusters group by group, that put them into the base's order, new ones last."""
    numbers: list[float] = []
    for group, count in zip(groups, counts, strict=True):
        numbers += group.members[:count] or [np.inf] * count
    return np.argsort(numbers, kind="stable")


def poses(space: LayoutSpace, values: FloatArray) -> Iterator[PlacedThrusters]:
    """The thrusters of layouts with parameters ``values`` (P, B), those of equally built layouts together."""
    built = thruster_counts(space, values)
    counts, of = np.unique(np.array(built), axis=1, return_inverse=True)
    for i, numbers in enumerate(counts.T.tolist()):
        which = np.flatnonzero(of.ravel() == i)
        if sum(numbers):
            yield _poses(space, values[:, which], which, numbers)


def _poses(space: LayoutSpace, values: FloatArray, which: IndexArray, counts: list[int]) -> PlacedThrusters:
    position, direction, limits = [], [], []
    for group, count in zip(space.groups, counts, strict=True):
        if not count:
            continue
        x, y, z, azimuth, cant = (space.values(setting, values) for setting in group.pose)
        azimuth, cant = np.radians(azimuth), np.radians(cant)
        e = np.array([np.cos(cant) * np.cos(azimuth), np.cos(cant) * np.sin(azimuth), np.sin(cant)])
        e[np.abs(e) < 1e-15] = 0.0  # cos 90 deg is 0, not 6e-17
        images = group.images[count]
        position.append(np.einsum("nij,jb->nib", images, np.array([x, y, z])))
        direction.append(np.einsum("nij,jb->nib", images * group.polarity[count][:, None, None], e))
        size = space.values(group.size, values)
        f_min, f_max, weights = np.array([group.f_min, group.f_max, group.weights])[:, :count, None]
        limits.append(np.array([f_min * size, f_max * size, weights * np.ones_like(size)]))
    order = base_order(space.groups, counts)
    f_min, f_max, weights = np.concatenate(limits, axis=1)[:, order]
    return PlacedThrusters(
        which=which,
        position=np.concatenate(position)[order],
        direction=np.concatenate(direction)[order],
        center=np.array([space.values(setting, values) for setting in space.center]),
        f_min=f_min,
        f_max=f_max,
        weights=weights,
    )


def combinations_of_grid(space: LayoutSpace) -> int:
    """Number of layouts of a grid."""
    return int(np.prod([len(parameter.grid) for parameter in space.parameters], dtype=object))


MIRRORS = {"xz": np.diag([1.0, -1.0, 1.0]), "yz": np.diag([-1.0, 1.0, 1.0]), "xy": np.diag([1.0, 1.0, -1.0])}
"""Reflections in planes through the origin of the vehicle's frame."""


def reflections(planes: tuple[str, ...] = ("xz", "yz", "xy")) -> list[FloatArray]:
    """All products of the reflections in these planes, the fewest first; the first is no reflection."""
    chosen = sorted(product((0, 1), repeat=len(planes)), key=lambda flips: (sum(flips), flips[::-1]))
    found = []
    for flips in chosen:
        matrix = np.eye(3)
        for plane, flip in zip(planes, flips, strict=True):
            matrix = matrix @ MIRRORS[plane] if flip else matrix
        found.append(matrix)
    return found


def turns(count: int) -> list[FloatArray]:
    """Turns about the vertical axis by equal angles; the first is none."""
    angles = 2 * np.pi * np.arange(count) / count
    return [
        np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0, 0, 1.0]]) for a in angles
    ]
